"""Spectrum of what is left: a line is a hum or a resonance, a hill is physics, flat is noise."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from er_model_lab.filtering import welch
from er_model_lab.output.report.figure import Axis, Figure, Level, Line, Mark, Panel
from er_model_lab.output.report.palette import AFTER, BEFORE, FLOOR
from er_model_lab.output.report.section import Section
from er_model_lab.output.text.units import newtons, short
from er_model_lab.view import Array, RecordView, View

LENGTH = 1024
"""Samples per segment of Welch's method."""


def section(view: View) -> Section | None:
    """Amplitude density of the residual; None when no record is long enough."""
    records = [
        r
        for r in view.records
        if r.t.size >= LENGTH // 4 and np.isfinite(r.measured - r.before).all()
    ]
    if not records:
        return None
    both = all(r.after is not None and np.isfinite(r.after).all() for r in records)
    f, before = density([r.measured - r.before for r in records], records)
    marks: list[Mark] = [Line(f, before, "model before" if both else "model", BEFORE, 1.6)]
    if both:
        _, after = density([r.measured - r.after for r in records if r.after is not None], records)
        marks.append(Line(f, after, "model after", AFTER, 1.6))
    floor = view.result.get("noise_floor")
    if floor:
        flat = float(floor) / np.sqrt(f[-1])
        marks.append(Level(flat, f"noise floor {newtons(floor)}, if white", FLOOR))
    peak = float(f[np.argmax(before)])
    alt = f"Amplitude density of the residual over frequency; it is largest at {short(peak)} Hz."
    y = Axis("residual [N/\N{SQUARE ROOT}Hz]", log=True)
    panel = Panel(tuple(marks), Axis("frequency [Hz]", (float(f[0]), float(f[-1])), log=True), y)
    return Section("spectrum", "Spectrum", (Figure("spectrum", alt, (panel,), height=340),))


def density(residuals: Sequence[Array], records: Sequence[RecordView]) -> tuple[Array, Array]:
    """Frequencies [Hz] and amplitude density [N/sqrt(Hz)], averaged over the records."""
    rate = 1.0 / float(np.median(np.diff(records[0].t)))
    length = min(LENGTH, *(r.size for r in residuals))
    total, weight, f = np.zeros(length // 2 + 1), 0.0, np.zeros(0)
    for e in residuals:
        f, power = welch(e, rate, length)
        total += power * e.size
        weight += e.size
    return np.asarray(f[1:]), np.sqrt(total[1:] / weight)
