"""What the part that no model explains depends on, so that its effect can be written."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from er_model_lab.output.report.figure import (
    Axis,
    Band,
    Bars,
    Figure,
    Line,
    Mark,
    Panel,
    Points,
    Scale,
    Tiles,
)
from er_model_lab.output.report.palette import BEFORE, FLOOR, INK, SIGNED
from er_model_lab.output.report.section import Section
from er_model_lab.output.text.units import factor, labelled, newtons, percent, short
from er_model_lab.residual.unexplained import skeleton
from er_model_lab.view import View

CURVES = 3
"""Curves that are drawn."""


def section(view: View) -> Section | None:
    """Inputs the residual depends on, curves, a map, and a file to begin with; None when nothing is left."""
    left = view.result.get("unexplained") or {}
    depends = {str(k): float(v) for k, v in (left.get("depends_on") or {}).items()}
    line, rest = left.get("line") or {}, left.get("rest") or {}
    hum = ""
    if line.get("share"):
        tone = f"a steady tone at {short(line['frequency'])} Hz of {newtons(line['amplitude'])}"
        hum = f"{tone}, {percent(line['share'])} of its power"
    if not depends and not hum and not rest:
        return None
    figures = [_figure(depends)] if depends else []
    shapes = _shapes(rest, view.result.get("noise_floor")) if rest else None
    if shapes is not None:
        figures.append(shapes)
    facts = {
        "share": percent(left.get("share")), "hum": hum, "says": rest.get("says") or (),
        "skeleton": skeleton(rest) if rest else "", "importance": bool(depends), "shapes": shapes is not None,
    }  # fmt: skip
    return Section("unexplained", "The rest", tuple(figures), facts)


def _shapes(rest: Mapping[str, Any], floor: float | None) -> Figure | None:
    """The mean of the rest over the quantities that explain most, and over the plane of two."""
    panels = [_curve(c, floor) for c in rest["curves"][:CURVES]]
    scale, plane = None, rest["map"]
    if plane is not None:
        z = np.array(
            [[np.nan if v is None else v for v in row] for row in plane["mean"]], np.float64
        )
        if np.isfinite(z).any():
            peak = float(np.nanquantile(np.abs(z), 0.98))
            scale = Scale("mean of the rest [N]", -peak, peak, SIGNED)
            x, y = (np.asarray(plane[f"{k}_edges"]) * factor(plane[f"{k}_unit"]) for k in "xy")
            labels = [Axis(labelled(plane[k], plane[f"{k}_unit"])) for k in "xy"]
            panels.append(Panel((Tiles(x, y, z),), labels[0], labels[1]))
    if not panels:
        return None
    alt = f"Mean of the rest over {', '.join(c['quantity'] for c in rest['curves'][:CURVES]) or 'a plane'}."
    rows = -(-len(panels) // 2)
    return Figure("unexplained_shapes", alt, tuple(panels), 2, height=300 * rows + 30, scale=scale)


def _curve(c: Mapping[str, Any], floor: float | None) -> Panel:
    """Mean of the rest over one quantity, with two standard errors."""
    at = np.asarray(c["at"]) * factor(c["unit"])
    mean, sd = np.asarray(c["mean"]), np.asarray(c["sd"])
    marks: list[Mark] = [
        Line(at, mean, "mean of the rest", BEFORE, 1.6),
        Points(at, mean, "", BEFORE, 4.0, 1.0),
        Line(at, mean - 2.0 * sd, "two standard errors", INK, 0.8, "dot"),
        Line(at, mean + 2.0 * sd, "", INK, 0.8, "dot"),
    ]
    if floor:
        marks.insert(0, Band(-floor, floor, "noise floor (rms)", FLOOR))
    title = f"{percent(c['share'])} of it"
    return Panel(tuple(marks), Axis(labelled(c["quantity"], c["unit"])), Axis("force [N]"), title)


def _figure(depends: dict[str, float]) -> Figure:
    """Loss of explained variance when one input is shuffled."""
    n = len(depends)
    at = np.arange(float(n))[::-1]
    values = np.array(list(depends.values()))
    ticks = tuple((float(a), name) for a, name in zip(at, depends, strict=True))
    text = tuple(percent(v) for v in values)
    bars = Bars(at, 100.0 * values, "", (BEFORE,) * n, text=text, horizontal=True, width=0.7)
    panel = Panel((bars,), Axis("loss of explained variance when shuffled [%]"), Axis(ticks=ticks))
    first = next(iter(depends))
    alt = f"Importance of the inputs for the rest of the residual; the first is {first}."
    return Figure("unexplained", alt, (panel,), height=110 + 30 * n)
