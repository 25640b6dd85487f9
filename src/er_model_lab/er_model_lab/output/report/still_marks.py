"""How Matplotlib draws each kind of mark."""

from __future__ import annotations

from dataclasses import dataclass
from functools import singledispatch
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable

from er_model_lab.output.report.figure import Band, Bars, Label, Level, Line, Points, Spans, Tiles
from er_model_lab.output.report.palette import INK, MUTED
from er_model_lab.output.report.thin import min_max

DASHES: dict[str, Any] = {"solid": "-", "dash": (0, (5, 3)), "dot": (0, (1, 2))}


@dataclass(frozen=True)
class Pen:
    """Where a mark is drawn: axes, colour scale, and the range of x that will be seen."""

    axes: Axes
    colours: ScalarMappable | None
    span: tuple[float, float] | None


@singledispatch
def draw(mark: object, _: Pen) -> None:
    """Draw one mark; `TypeError` for anything that is no mark."""
    raise TypeError(f"{type(mark).__name__} is no mark")


@draw.register
def _line(mark: Line, pen: Pen) -> None:
    x, y = mark.x, mark.y
    if pen.span:
        seen = np.flatnonzero((x >= pen.span[0]) & (x <= pen.span[1]))
        # one sample more on either side, so that the curve reaches the edge
        cut = slice(max(int(seen[0]) - 1, 0), int(seen[-1]) + 2) if seen.size else slice(0, 0)
        x, y = x[cut], y[cut]
    rows = min_max(y)
    pen.axes.plot(
        x[rows], y[rows], label=mark.name or None, color=mark.colour, lw=mark.width,
        ls=DASHES[mark.dash],
    )  # fmt: skip


@draw.register
def _points(mark: Points, pen: Pen) -> None:
    colour: dict[str, Any] = {"color": mark.colour}
    if not isinstance(mark.colour, str):
        if pen.colours is None:
            raise TypeError("points with values need a figure with a scale")
        colour = {"c": pen.colours.to_rgba(mark.colour)}
    # thousands of dots as vectors would make the file large and slow
    pen.axes.scatter(
        mark.x, mark.y, s=mark.size**2 * 0.6, lw=0, alpha=mark.alpha, rasterized=True,
        label=mark.name or None, **colour,
    )  # fmt: skip


@draw.register
def _bars(mark: Bars, pen: Pen) -> None:
    base = np.zeros(mark.at.size) if mark.base is None else mark.base
    colours = list(mark.colours)
    error = None
    if mark.ends is not None:
        tip = base + mark.size
        error = np.clip(np.stack([tip - mark.ends[0], mark.ends[1] - tip]), 0.0, None)
    style: dict[str, Any] = {
        "ecolor": INK,
        "error_kw": {"lw": 1.0, "capsize": 2.5},
        "label": mark.name or None,
    }
    if mark.horizontal:
        bars = pen.axes.barh(
            mark.at, mark.size, mark.width, base, color=colours, xerr=error, **style
        )
    else:
        bars = pen.axes.bar(
            mark.at, mark.size, mark.width, base, color=colours, yerr=error, **style
        )
    if mark.text:
        pen.axes.bar_label(bars, list(mark.text), padding=3, fontsize=8.5, color=INK)
        room = {"x": 0.15} if mark.horizontal else {"y": 0.15}
        pen.axes.margins(x=room.get("x"), y=room.get("y"))


@draw.register
def _tiles(mark: Tiles, pen: Pen) -> None:
    if pen.colours is None:
        raise TypeError("tiles need a figure with a scale")
    z = np.ma.masked_invalid(mark.z)
    mesh: dict[str, Any] = {"cmap": pen.colours.cmap, "norm": pen.colours.norm, "rasterized": True}
    pen.axes.pcolormesh(mark.x_edges, mark.y_edges, z, **mesh)
    pen.axes.grid(visible=False)


@draw.register
def _band(mark: Band, pen: Pen) -> None:
    pen.axes.axhspan(
        mark.low, mark.high, color=mark.colour, alpha=0.16, lw=0, label=mark.name or None
    )


@draw.register
def _spans(mark: Spans, pen: Pen) -> None:
    for k, (low, high) in enumerate(mark.stretches):
        name = mark.name if k == 0 and mark.name else None
        pen.axes.axvspan(low, high, color=mark.colour, alpha=0.4, lw=0, zorder=0.5, label=name)


@draw.register
def _level(mark: Level, pen: Pen) -> None:
    line = pen.axes.axvline if mark.vertical else pen.axes.axhline
    line(mark.value, label=mark.name or None, color=mark.colour, lw=1.4, ls=DASHES[mark.dash])


@draw.register
def _label(mark: Label, pen: Pen) -> None:
    pen.axes.annotate(
        mark.text, (mark.x, 1.0), xycoords=("data", "axes fraction"), fontsize=8, color=MUTED,
        ha="left", va="bottom", annotation_clip=True,
    )  # fmt: skip
