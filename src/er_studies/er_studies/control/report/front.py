"""Deflection against comfort of several controllers: the nearer to the lower left, the better."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from er_studies.control.contest import Line

PLACES = tuple((x, y) for y in (4, -10, 12, -18) for x in (4, -4))
"""Where a name may stand beside its point, to the right or the left, in the order in which it is tried [pt]."""


def front_picture(path: Path, lines: Sequence[Line]) -> None:
    """Mean changes against the passive car, one panel for each kind of road and fault; tyre load in brackets."""
    panels = list(dict.fromkeys((line.kind, line.fault) for line in lines))
    figure = Figure(figsize=(12.0, 3.8 * ((len(panels) + 1) // 2)), layout="constrained")
    axes = figure.subplots((len(panels) + 1) // 2, 2, squeeze=False).ravel()
    for axis, (kind, fault) in zip(axes, panels, strict=False):
        here = [line for line in lines if (line.kind, line.fault) == (kind, fault)]
        for line in here:
            ours = line.name == "fault_tolerant"
            axis.scatter(
                *(100.0 * line.change[:2]),
                s=90 if ours else 40,
                marker="*" if ours else "o",
                color="C3" if ours else "C0",
            )
        axis.axhline(0.0, color="0.6", linewidth=0.8)
        axis.axvline(0.0, color="0.6", linewidth=0.8)
        axis.set(
            title=f"{kind}, {fault} (tyre load in brackets)",
            xlabel="deflection [%]",
            ylabel="comfort [%]",
        )
        axis.grid(visible=True, alpha=0.3)
        axis.margins(0.12)
    figure.draw_without_rendering()
    for axis, panel in zip(axes, panels, strict=False):
        _name(axis, [line for line in lines if (line.kind, line.fault) == panel])
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)


def _name(axis: Axes, lines: Sequence[Line]) -> None:
    """Names with the tyre load beside the points, each where it covers nothing and stays in the panel, if it can."""
    points = axis.transData.transform([100.0 * line.change[:2] for line in lines])
    taken = [Bbox.from_extents(x - 4.0, y - 4.0, x + 4.0, y + 4.0) for x, y in points]
    for line in lines:
        x, y, tyre = (100.0 * float(v) for v in line.change[:3])
        for place in PLACES:
            text = axis.annotate(
                f"{line.name} ({tyre:+.1f})", (x, y), place, textcoords="offset points",
                fontsize=7, ha="left" if place[0] > 0 else "right",
            )  # fmt: skip
            box = text.get_window_extent()
            inside = axis.bbox.containsx(box.x0) and axis.bbox.containsx(box.x1)
            if (inside and not box.count_overlaps(taken)) or place == PLACES[-1]:
                break
            text.remove()
        taken.append(box)
