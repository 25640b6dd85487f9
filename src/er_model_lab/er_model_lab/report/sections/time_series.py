"""Measured and predicted force over time, what is left, and the motion and duty that caused it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from er_model_lab.report.figure import Axis, Band, Figure, Label, Line, Mark, Panel, Spans
from er_model_lab.report.palette import AFTER, BEFORE, FLOOR, HELD_OUT, MEASURED, MUTED
from er_model_lab.report.section import Section
from er_model_lab.report.thin import end_to_end, stretches, timeline, worst_stretch
from er_model_lab.report.units import newtons, short
from er_model_lab.view import Array, RecordView, View

SECONDS = 5.0
"""Length of the stretch that is shown first."""
GRAIN = 0.05
"""Share of the noise floor to which forces are kept for zooming."""


def section(view: View) -> Section | None:
    """All records end to end, starting where the model is worst; None without records."""
    records = [r for r in view.records if r.t.size > 2]
    if not records:
        return None
    times = timeline(records)
    k = max(range(len(records)), key=lambda i: worst_stretch(records[i], SECONDS)[2])
    low, high, rms = worst_stretch(records[k], SECONDS)
    shift = float(times[k][0] - records[k].t[0])
    start = (low + shift, high + shift)
    where = f"{short(low)} s to {short(high)} s of {records[k].name}"
    figure = _figure(
        view, records, times, start, f"Shown is the stretch of largest error, {where}."
    )
    facts = {
        "where": where,
        "rms": newtons(rms),
        "records": len(records),
        "split": any(r.held_out.any() for r in records),
    }
    return Section("time_series", "Force over time", (figure,), facts)


def _figure(
    view: View,
    records: list[RecordView],
    times: tuple[Array, ...],
    start: tuple[float, float],
    words: str,
) -> Figure:
    """Four linked panels: force, residual, velocity, duty."""
    t = end_to_end(times)

    grain = GRAIN * float(view.result.get("noise_floor") or 0.0)

    def curve(
        of: Callable[[RecordView], Array | None], name: str, colour: str, width: float = 1.3
    ) -> list[Mark]:
        parts = [of(r) for r in records]
        if any(p is None for p in parts):
            return []
        y = end_to_end([p for p in parts if p is not None])
        return [Line(t, y, name, colour, width, grain=grain if name else 0.0)]

    held: list[Mark] = _held_out(records, times)
    labels: list[Mark] = (
        [Label(float(x[0]), r.name) for r, x in zip(records, times, strict=True)]
        if len(records) > 1
        else []
    )
    both = all(r.after is not None for r in records)
    before = "model before" if both else "model"
    force = curve(lambda r: r.measured, "measured", MEASURED, 1.1) + curve(
        lambda r: r.before, before, BEFORE
    )
    force += curve(lambda r: r.after, "model after", AFTER)
    left = curve(lambda r: r.measured - r.before, before, BEFORE)
    left += curve(
        lambda r: None if r.after is None else r.measured - r.after, "model after", AFTER
    )
    span = Axis(span=start)
    label = "time [s]" if len(records) == 1 else "time, records laid end to end [s]"
    panels = (
        Panel((*held, *force, *labels), span, Axis("force [N]")),
        Panel((*held, *_floor(view), *left), span, Axis("residual [N]")),
        Panel(tuple(curve(lambda r: 1e3 * r.velocity, "", MUTED, 1.0)), span, Axis("v [mm/s]")),
        Panel(tuple(curve(lambda r: r.duty, "", MUTED, 1.2)), Axis(label, start), Axis("duty")),
    )
    alt = f"Force measured and predicted over time, what is left of it, velocity and duty. {words}"
    return Figure(
        "time_series", alt, panels, height=720, heights=(3.0, 2.2, 1.0, 1.0), linked=True
    )


def _held_out(records: list[RecordView], times: tuple[Array, ...]) -> list[Mark]:
    """Shading of what was never fitted."""
    found = [
        s for r, x in zip(records, times, strict=True) for s in stretches(x, r.held_out & r.scored)
    ]
    return [Spans(tuple(found), "held out", HELD_OUT)] if found else []


def _floor(view: View) -> list[Mark]:
    """Band in which noise alone stays 95 % of the time."""
    floor = view.result.get("noise_floor")
    if floor is None or not np.isfinite(floor):
        return []
    return [Band(-2.0 * floor, 2.0 * floor, "noise floor (2 rms, 95 %)", FLOOR)]
