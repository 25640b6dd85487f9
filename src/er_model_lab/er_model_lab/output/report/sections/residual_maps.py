"""Where in the plane of velocity, deflection and duty the model errs."""

from __future__ import annotations

import numpy as np

from er_model_lab.output.report.figure import (
    Axis,
    Band,
    Figure,
    Line,
    Mark,
    Panel,
    Points,
    Scale,
    Tiles,
)
from er_model_lab.output.report.palette import AFTER, BEFORE, ERROR, FLOOR
from er_model_lab.output.report.samples import Samples, binned_mean, margin, rms_map, samples
from er_model_lab.output.report.section import Section
from er_model_lab.output.report.thin import every
from er_model_lab.output.text.units import newtons
from er_model_lab.view import Array, View

MOST_DOTS = 1500
"""Dots per curve of the residual loops."""


def section(view: View) -> Section | None:
    """Residual loops, and maps of the rms residual; None without records."""
    s = samples(view.records)
    if s is None:
        return None
    floor = view.result.get("noise_floor")
    return Section(
        "residual_maps", "Residual", (_loops(s, floor), _maps(s)), {"both": s.after is not None}
    )


def _residuals(s: Samples) -> list[tuple[str, Array, str]]:
    """Name, residual (n,) and colour of each model."""
    return [
        (name, s.measured - f, c) for (name, f), c in zip(s.models, (BEFORE, AFTER), strict=False)
    ]


def _loops(s: Samples, floor: float | None) -> Figure:
    """Residual against velocity and deflection, and its mean: a pattern is physics."""
    rows = every(s.measured.size, MOST_DOTS)
    found = _residuals(s)
    span = margin(*(r[rows] for _, r, _ in found))
    panels = []
    for k, (label, x) in enumerate(
        (("velocity [mm/s]", 1e3 * s.velocity), ("deflection [mm]", 1e3 * s.deflection))
    ):
        marks: list[Mark] = [
            Points(x[rows], r[rows], "", colour, 3.0, 0.25) for _, r, colour in found
        ]
        marks += [
            Line(*binned_mean(x, r), f"{name}, mean", colour, 2.4) for name, r, colour in found
        ]
        if floor is not None:
            marks.append(Band(-2.0 * floor, 2.0 * floor, "noise floor (2 rms, 95 %)", FLOOR))
        panels.append(
            Panel(
                tuple(marks),
                Axis(label, margin(x[rows])),
                Axis("" if k else "residual: measured \N{MINUS SIGN} model [N]", span),
            )
        )
    worst = [float(np.max(np.abs(binned_mean(s.velocity, r)[1]))) for _, r, _ in found]
    words = " and ".join(
        f"{newtons(w)} for the {name}" for w, (name, _, _) in zip(worst, found, strict=True)
    )
    alt = f"Residual against velocity and deflection; its mean over velocity reaches {words}."
    return Figure("residual_loops", alt, tuple(panels), 2, height=360)


def _maps(s: Samples) -> Figure:
    """Maps over velocity and deflection, and duty where it varies; one row per model."""
    planes = [("deflection [mm]", 1e3 * s.deflection, (30, 18))]
    if s.steps_duty:
        planes.append(("duty", s.duty, (30, 10)))
    panels, peak = [], 0.0
    for name, residual, _ in _residuals(s):
        for label, y, bins in planes:
            tiles = Tiles(*rms_map(1e3 * s.velocity, y, residual, bins))
            if np.isfinite(tiles.z).any():
                peak = max(peak, float(np.nanquantile(tiles.z, 0.99)))
            panels.append(Panel((tiles,), Axis("velocity [mm/s]"), Axis(label), name))
    others = " and over velocity and ".join(label.split(" ")[0] for label, _, _ in planes)
    alt = f"Maps of the rms residual over velocity and {others}."
    height = 300 * (-(-len(panels) // len(planes))) + 40
    scale = Scale("rms residual [N]", 0.0, peak, ERROR)
    return Figure("residual_maps", alt, tuple(panels), len(planes), height=height, scale=scale)
