"""Loops of force against velocity and deflection: measured beside the model, coloured by duty."""

from __future__ import annotations

from er_model_lab.output.report.figure import Axis, Figure, Panel, Points, Scale
from er_model_lab.output.report.palette import AFTER, BEFORE, DUTY, MEASURED
from er_model_lab.output.report.samples import Samples, margin, samples
from er_model_lab.output.report.section import Section
from er_model_lab.output.report.thin import every
from er_model_lab.view import Array, View

MOST_DOTS = 1600
"""Dots per panel."""


def section(view: View) -> Section | None:
    """Force-velocity and force-deflection, one column for the measurement and each model."""
    s = samples(view.records)
    if s is None:
        return None
    rows = every(s.measured.size, MOST_DOTS)
    forces: list[tuple[str, Array, str]] = [("measured", s.measured, MEASURED)]
    colours = (BEFORE, AFTER)
    forces += [(name, f, c) for (name, f), c in zip(s.models, colours, strict=False)]
    span = margin(*(f[rows] for _, f, _ in forces))
    panels = []
    for row, (label, x) in enumerate(
        (
            ("velocity [mm/s]", 1e3 * s.velocity[rows]),
            ("deflection [mm]", 1e3 * s.deflection[rows]),
        )
    ):
        for k, (name, f, colour) in enumerate(forces):
            dots = Points(x, f[rows], "", s.duty[rows] if s.steps_duty else colour, 3.2, 1.0)
            y = Axis("force [N]" if k == 0 else "", span)
            panels.append(Panel((dots,), Axis(label, margin(x)), y, "" if row else name))
    return Section(
        "loops", "Loops", (_figure(s, tuple(panels), len(forces)),), {"duty": s.steps_duty}
    )


def _figure(s: Samples, panels: tuple[Panel, ...], columns: int) -> Figure:
    """Two rows of loops on common axes."""
    scale = Scale("duty", float(s.duty.min()), float(s.duty.max()), DUTY) if s.steps_duty else None
    alt = (
        "Force against velocity (top) and against deflection (bottom), measured and "
        "predicted side by side on equal axes; measured were forces from "
        f"{s.measured.min():.3g} N to {s.measured.max():.3g} N."
    )
    return Figure("loops", alt, panels, columns, height=640, scale=scale)
