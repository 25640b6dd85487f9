"""Draws a figure with Matplotlib: the PNG and SVG files, and what the page shows in print."""

from __future__ import annotations

from collections.abc import Iterable
from io import BytesIO
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure as Canvas
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from PIL import Image

from er_model_lab.output.report.figure import Figure, Panel, Scale
from er_model_lab.output.report.palette import INK, MUTED, RULE
from er_model_lab.output.report.still_marks import Pen, draw

Drawing = Canvas
"""A figure of Matplotlib's, as it is returned."""

DPI, DPI_OF_PNG = 100, 150
FAST = 4
"""Compression of PNG files: two thirds of the time of the usual 6, for 2 % more bytes."""
STYLE: dict[Any, Any] = {
    "font.family": "sans-serif", "font.sans-serif": ["DejaVu Sans", "Arial"], "font.size": 10.0,
    "text.color": INK, "axes.labelcolor": INK, "axes.edgecolor": MUTED, "axes.linewidth": 0.7,
    "axes.titlesize": 10.5, "axes.titleweight": "bold", "axes.titlelocation": "left",
    "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": RULE, "grid.linewidth": 0.6, "xtick.color": MUTED, "ytick.color": MUTED,
    "legend.frameon": False, "legend.fontsize": 10.0, "svg.fonttype": "none", "svg.hashsalt": "er",
}  # fmt: skip


def still(figure: Figure) -> tuple[bytes, bytes]:
    """The figure as (PNG, SVG); the same figure always gives the same bytes."""
    with matplotlib.rc_context(STYLE):
        canvas = _canvas(figure)
        svg, png = BytesIO(), BytesIO()
        # the layout is found once, and left; `savefig` would draw each format once more to find it
        ConstrainedLayoutEngine().execute(canvas)
        canvas.set_layout_engine("none")
        lines: Any = FigureCanvasSVG(canvas)
        lines.print_svg(svg, metadata={"Date": None, "Creator": None})
        canvas.set_dpi(DPI_OF_PNG)
        pixels: Any = FigureCanvasAgg(canvas)
        pixels.draw()
    opaque = Image.fromarray(np.asarray(pixels.buffer_rgba())).convert("RGB")
    opaque.save(png, "PNG", compress_level=FAST, dpi=(DPI_OF_PNG, DPI_OF_PNG))
    return png.getvalue(), svg.getvalue()


def canvas(figure: Figure) -> Drawing:
    """The figure as one of Matplotlib's, to be shown or changed."""
    with matplotlib.rc_context(STYLE):
        return _canvas(figure)


def _canvas(figure: Figure) -> Canvas:
    """All panels, one legend, one colour scale."""
    size = (figure.width / DPI, figure.height / DPI)
    canvas = Canvas(figsize=size, dpi=DPI, layout="constrained", facecolor="white")
    FigureCanvasAgg(canvas)
    grid = canvas.subplots(
        figure.rows, figure.columns, squeeze=False, sharex=figure.linked,
        gridspec_kw={"height_ratios": figure.shares},
    )  # fmt: skip
    colours = _colours(figure.scale) if figure.scale else None
    used = list(grid.flat[: len(figure.panels)])
    for axes, panel in zip(used, figure.panels, strict=True):
        pen = Pen(axes, colours, panel.x.span)
        for mark in panel.marks:
            draw(mark, pen)
        _axes(panel, axes)
    for axes in grid.flat[len(used) :]:
        axes.set_axis_off()
    if colours is not None and figure.scale is not None:
        bar = canvas.colorbar(colours, ax=grid, aspect=40, pad=0.01, fraction=0.03)
        bar.set_label(figure.scale.label)
    _legend(canvas, used)
    return canvas


def _colours(scale: Scale) -> ScalarMappable:
    """Colours of the figure's scale; an empty range is widened so that it can be drawn."""
    colours = LinearSegmentedColormap.from_list("scale", list(scale.stops))
    high = scale.high if scale.high > scale.low else scale.low + 1.0
    return ScalarMappable(Normalize(scale.low, high), colours)


def _axes(panel: Panel, axes: Axes) -> None:
    """Labels, ranges and ticks of one panel."""
    axes.set(xlabel=panel.x.label, ylabel=panel.y.label, title=panel.title)
    for on, axis, name in ((panel.x.log, axes.xaxis, "x"), (panel.y.log, axes.yaxis, "y")):
        if on:
            axes.set(**{f"{name}scale": "log"})
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axis.set_minor_formatter(NullFormatter())
    if panel.x.span:
        axes.set_xlim(*panel.x.span)
    if panel.y.span:
        axes.set_ylim(*panel.y.span)
    if panel.x.ticks:
        size = 8.0 if len(panel.x.ticks) > 5 else 10.0
        axes.set_xticks(
            [at for at, _ in panel.x.ticks], [text for _, text in panel.x.ticks], fontsize=size
        )
        axes.grid(visible=False, axis="x")
    if panel.y.ticks:
        axes.set_yticks([at for at, _ in panel.y.ticks], [text for _, text in panel.y.ticks])
        axes.grid(visible=False, axis="y")


def _legend(canvas: Canvas, panels: Iterable[Axes]) -> None:
    """One entry for each name in the whole figure, above the panels."""
    entries: dict[Any, Any] = {}
    for axes in panels:
        for handle, name in zip(*axes.get_legend_handles_labels(), strict=True):
            entries.setdefault(name, handle)
    if entries:
        columns = min(len(entries), 6)
        where: dict[str, Any] = {
            "loc": "outside upper center",
            "ncols": columns,
            "markerscale": 2.0,
        }
        canvas.legend(list(entries.values()), list(entries), **where)
