"""The page of chapter 2: the passive car, responses of the forms, all forms on one road, what sensors tell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from er_common.versions import versions
from er_model_lab.output.report.figure import Axis, Figure, Level, Line, Mark, Panel
from er_model_lab.output.report.palette import AFTER, BEFORE, FLOOR, MEASURED, MUTED
from er_model_lab.output.report.section import Section
from er_model_lab.output.report.sections import provenance
from er_model_lab.view import Array, View
from er_models.forms.passive import OUTPUTS

from er_studies.command_line import command_line
from er_studies.thesis import chapter_2_text as present
from er_studies.thesis.chapter_2 import HERTZ, LEAK, SLOW, Chapter2

COLOURS = (MEASURED, AFTER, BEFORE, FLOOR, "#cc79a7")
"""One colour per curve of a panel, apart for colour-blind readers."""
READ = (4.0, 20.0)
"""Peaks the thesis reads from its figures 6.13 to 6.15 [Hz]."""


def view(found: Chapter2, data: Mapping[str, Any]) -> View:
    """What the page needs beside its sections."""
    known = {
        "damper": found.model.digest(),
        "versions": versions(),
        "command_line": command_line(),
    }
    return View("thesis", "chapter 2", "", result=data, records=(), notes=(), provenance=known)


def sections(found: Chapter2, data: Mapping[str, Any]) -> list[Section]:
    """All sections of the page."""
    made = [_passive(found), _responses(found), _ride(found), _leak(found), _sensing(found)]
    last = provenance.section(view(found, data))
    return [*made, last] if last else made


def _passive(found: Chapter2) -> Section:
    """Figures 6.13 to 6.15."""
    panels = tuple(
        Panel(
            (Line(HERTZ, decibels(gain), "passive car", MEASURED, 1.6), *_read()),
            _hertz(),
            Axis("gain [dB]"),
            f"{name} / z_r",
        )
        for name, gain in zip(OUTPUTS, found.bode.passive.T, strict=True)
    )
    alt = "Gain from the road to body, wheel and deflection of the passive car, as figures 6.13 to 6.15."
    text = ("Dashed: the peaks that the thesis reads from its figures, 4 and 20 Hz.",)
    facts = {"text": text, "head": present.HEAD_PEAKS, "rows": present.peaks(found)}
    figure = Figure("passive_car", alt, panels, columns=3, height=340)
    return Section("passive_car", "Passive car", (figure,), facts, "prose")


def _responses(found: Chapter2) -> Section:
    """Bode diagrams of (2.8), (2.10) and of (2.11) around a held duty."""
    b = found.bode
    titles = ("sprung acceleration", "unsprung acceleration", "deflection")
    units = ("dB re 1 m/s2 / N", "dB re 1 m/s2 / N", "dB re 1 mm / N")
    by_force = tuple(
        _curves({"over the fluid's force u_er": gain * scale}, f"gain [{unit}]", title)
        for gain, title, unit, scale in zip(
            b.suspension.T, titles, units, (1.0, 1.0, 1e3), strict=True
        )
    )
    fluid = _curves({f"gate {g:g}": gain for g, gain in b.fluid.items()}, "gain [dB re 1 N]")
    force = _curves({f"duty {u:g}": gain for u, gain in b.force.items()}, "gain [dB re 1 N s/m]")
    figures = (
        Figure(
            "suspension",
            "Suspension (2.8): accelerations and deflection over u_er.",
            by_force,
            3,
            340,
        ),
        Figure("fluid", "Fluid (2.10): F_er over the duty, at held gates.", (fluid,), height=340),
        Figure("whole_car", "Whole car (2.11): F_d over the rate of the road, small motions.", (force,), height=340),
    )  # fmt: skip
    text = (
        "Suspension (2.8) over the fluid's force; fluid (2.10) over the duty; damper force of the whole car (2.11) "
        "over the rate of the road. Small motions stay within the gate: there the field almost locks the damper, and "
        "body and wheel swing together on the tyre. Beyond yield the curve is that of duty 0.",
    )
    return Section(
        "responses", "Responses of the forms", figures, {"text": text, "rows": ()}, "prose"
    )


def _ride(found: Chapter2) -> Section:
    """All forms on one road, and how far each is from the compiled model."""
    r = found.ride
    panels = [
        Panel((Line(r.t, 1e3 * r.road, "", MUTED),), Axis(), Axis("road [mm]")),
        Panel((Line(r.t, r.duty, "", MUTED),), Axis(), Axis("duty")),
        Panel((Line(r.t, r.record[:, 3], "compiled model", MEASURED),), Axis(), Axis("F_d [N]")),
    ]
    scale = np.ptp(r.record[:, 3])
    sizes = [_magnitude(y[:, 3] - r.record[:, 3], scale) for y in r.forms.values()]
    apart: list[Mark] = [
        Line(r.t, size, name, colour)
        for name, size, colour in zip(r.forms, sizes, COLOURS[1:], strict=True)
    ]
    panels.append(Panel(tuple(apart), Axis("time [s]"), _decades("share of range", sizes)))
    alt = "Road, duty, damper force, and the difference of each form to the compiled model on a logarithmic scale."
    figure = Figure(
        "ride", alt, tuple(panels), height=680, heights=(1.0, 1.0, 2.0, 2.0), linked=True
    )
    text = (
        "Each form is driven by its own inputs (height of the road, its rate, the rate of the tyre's deflection). "
        "What is left is the error of the integrators: no equation of a form was written by hand.",
    )
    facts = {"text": text, "head": present.HEAD_RIDE, "rows": present.ride(found)}
    return Section("ride", "All forms on one road", (figure,), facts, "prose")


def _leak(found: Chapter2) -> Section:
    """The descriptor form with a leaking damper."""
    r = found.ride
    force = (
        Line(r.t, r.record[:, 3], "healthy", MUTED),
        Line(r.t, r.leaking[:, 3], "leaking, compiled model", MEASURED),
        Line(r.t, r.descriptor[:, 3], "leaking, (2.19)", AFTER, dash="dash"),
    )
    panels = (
        Panel(force, Axis(), Axis("force left [N]")),
        Panel((Line(r.t, r.lost, "", BEFORE),), Axis("time [s]"), Axis("f [N]")),
    )
    alt = "Force of the healthy and of the leaking damper, by compiled model and descriptor form; lost force."
    text = (
        f"Oil leakage f_2 = {100 * LEAK.leakage:.0f} % as in section 6.4. The lost force f = (1 - f_2) F_d is the "
        "sixth state.",
    )
    figure = Figure("leak", alt, panels, height=420, heights=(2.0, 1.0), linked=True)
    return Section(
        "leak", "Descriptor form with a fault", (figure,), {"text": text, "rows": ()}, "prose"
    )


def _sensing(found: Chapter2) -> Section:
    """Zeros, and how clearly slow motions show."""
    panels = []
    for unknown in dict.fromkeys(s.unknowns for s in found.systems):
        chosen = {
            " + ".join((s.velocities, *s.sensors[1:])): visible
            for s, visible in zip(found.systems, found.visible, strict=True)
            if s.unknowns == unknown
        }
        panels.append(_visible(chosen, "unknown: " + " and ".join(unknown)))
    alt = "Smallest singular value of the system pencil over frequency: it falls to zero towards a zero at s = 0."
    text = (
        "A motion that moves no sensor cannot be told from rest, whatever the observer. In absolute velocities a climb "
        "at constant speed is one. With an unknown lost force the deflection itself is one, unless it is measured.",
    )
    facts = {"text": text, "head": present.HEAD_ZEROS, "rows": present.zeros(found)}
    figure = Figure("sensing", alt, tuple(panels), columns=2, height=400)
    return Section("sensing", "What sensors tell", (figure,), facts, "prose")


def _visible(chosen: Mapping[str, Array], title: str) -> Panel:
    """Curves of the systems with the same unknown inputs."""
    marks = tuple(
        Line(SLOW, _magnitude(v, 1.0), name, colour)
        for (name, v), colour in zip(chosen.items(), COLOURS, strict=False)
    )
    frequency = _decades("frequency [Hz]", [SLOW])
    return Panel(marks, frequency, _decades("visibility", list(chosen.values())), title)


def _curves(gains: Mapping[str, Array], label: str, title: str = "") -> Panel:
    """Gains over frequency in decibels."""
    marks = tuple(
        Line(HERTZ, decibels(gain), name, colour)
        for (name, gain), colour in zip(gains.items(), COLOURS, strict=False)
    )
    return Panel(marks, _hertz(), Axis(label), title)


def decibels(gain: Array) -> Array:
    """A gain in dB; what is zero is left out."""
    return 20.0 * np.log10(_magnitude(gain, 1.0))


def _decades(label: str, values: Sequence[Array]) -> Axis:
    """A logarithmic axis over several decades, with a tick for each or for every second or third."""
    every = np.concatenate([v[np.isfinite(v) & (v > 0.0)] for v in values])
    low, high = (int(f(np.log10(e))) for f, e in ((np.floor, every.min()), (np.ceil, every.max())))
    powers = range(low, high + 1, max(1, (high - low) // 4))
    span = (10.0**low, 10.0**high)
    return Axis(label, span, tuple((10.0**k, f"1e{k}") for k in powers), log=True)


def _hertz() -> Axis:
    """The axis of frequency."""
    return Axis("frequency [Hz]", (float(HERTZ[0]), float(HERTZ[-1])), log=True)


def _read() -> Sequence[Level]:
    """What the thesis reads from its figures."""
    return [Level(f, "read by the thesis", BEFORE, vertical=True) for f in READ]


def _magnitude(values: Array, scale: float) -> Array:
    """Sizes over a scale for a logarithmic axis: what is zero is left out."""
    size = np.abs(values) / scale
    return np.where(size > 0.0, size, np.nan)
