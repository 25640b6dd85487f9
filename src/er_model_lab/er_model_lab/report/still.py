"""Draws a figure with Matplotlib: the PNG and SVG files, and what the page shows in print."""

from __future__ import annotations

import warnings
from functools import singledispatch
from io import BytesIO

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure as Canvas

from er_model_lab.report import figure as f
from er_model_lab.report.palette import INK, MUTED, RULE
from er_model_lab.report.thin import min_max

DPI = 100
STYLE = {
    "font.family": "sans-serif", "font.sans-serif": ["DejaVu Sans", "Arial"], "font.size": 9.0,
    "text.color": INK, "axes.labelcolor": INK, "axes.edgecolor": MUTED, "axes.linewidth": 0.7,
    "axes.titlesize": 9.5, "axes.titleweight": "bold", "axes.titlelocation": "left",
    "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "axes.axisbelow": True,
    "grid.color": RULE, "grid.linewidth": 0.6, "xtick.color": MUTED, "ytick.color": MUTED,
    "legend.frameon": False, "legend.fontsize": 9.0, "svg.fonttype": "none", "svg.hashsalt": "er",
    "path.simplify_threshold": 0.3,
}  # fmt: skip
DASHES = {"solid": "-", "dash": (0, (5, 3)), "dot": (0, (1, 2))}


def still(figure: f.Figure) -> tuple[bytes, bytes]:
    """The figure as (PNG, SVG); the same figure always gives the same bytes."""
    with matplotlib.rc_context(STYLE), warnings.catch_warnings():
        # a label wider than a narrow panel is a matter of looks, not of truth
        warnings.filterwarnings("ignore", message="constrained_layout not applied")
        canvas = _draw(figure)
        png, svg = BytesIO(), BytesIO()
        canvas.savefig(svg, format="svg", metadata={"Date": None, "Creator": None}, dpi=130)
        canvas.savefig(png, format="png", metadata={"Software": None}, dpi=150)
    return png.getvalue(), svg.getvalue()


def _draw(figure: f.Figure) -> Canvas:
    """All panels, one legend, one colour scale."""
    canvas = Canvas(figsize=(figure.width / DPI, figure.height / DPI), layout="constrained", facecolor="white")
    FigureCanvasAgg(canvas)
    grid = canvas.subplots(
        figure.rows, figure.columns, squeeze=False, sharex=figure.linked,
        gridspec_kw={"height_ratios": figure.shares},
    )  # fmt: skip
    colours = _mappable(figure.scale)
    for axes, panel in zip(grid.flat, figure.panels, strict=False):
        for mark in panel.marks:
            _mark(mark, axes, colours)
        _axes(panel, axes)
    for axes in grid.flat[len(figure.panels) :]:
        axes.set_axis_off()
    if colours is not None and figure.scale is not None:
        bar = canvas.colorbar(colours, ax=grid, aspect=40, pad=0.01, fraction=0.03)
        bar.set_label(figure.scale.label)
        bar.outline.set_visible(False)  # type: ignore[operator]
    _legend(canvas, grid.flat[: len(figure.panels)])
    return canvas


def _mappable(scale: f.Scale | None) -> ScalarMappable | None:
    """Colours of the figure's scale."""
    if scale is None:
        return None
    colours = LinearSegmentedColormap.from_list(scale.label, list(scale.stops))
    return ScalarMappable(Normalize(scale.low, scale.high), colours)


def _axes(panel: f.Panel, axes: Axes) -> None:
    """Labels, ranges and ticks of one panel."""
    axes.set(xlabel=panel.x.label, ylabel=panel.y.label, title=panel.title)
    if panel.y.log:
        axes.set_yscale("log")
    if panel.x.log:
        axes.set_xscale("log")
    if panel.x.span:
        axes.set_xlim(*panel.x.span)
    if panel.y.span:
        axes.set_ylim(*panel.y.span)
    if panel.x.ticks:
        axes.set_xticks([at for at, _ in panel.x.ticks], [text for _, text in panel.x.ticks])
        axes.grid(visible=False, axis="x")
    if panel.y.ticks:
        axes.set_yticks([at for at, _ in panel.y.ticks], [text for _, text in panel.y.ticks])
        axes.grid(visible=False, axis="y")


def _legend(canvas: Canvas, panels: list[Axes]) -> None:
    """One entry for each name in the whole figure, above the panels."""
    entries = {}
    for axes in panels:
        for handle, name in zip(*axes.get_legend_handles_labels(), strict=True):
            entries.setdefault(name, handle)
    if entries:
        canvas.legend(list(entries.values()), list(entries), loc="outside upper center", ncols=min(len(entries), 5))


@singledispatch
def _mark(mark: object, axes: Axes, colours: ScalarMappable | None) -> None:
    """Draw one mark."""
    raise TypeError(f"no drawing for {type(mark).__name__}")


@_mark.register
def _(mark: f.Line, axes: Axes, colours: ScalarMappable | None) -> None:
    rows = min_max(mark.y)
    if rows.size < mark.y.size and (span := axes.get_xlim()) == (0.0, 1.0):
        del span
    axes.plot(mark.x[rows], mark.y[rows], color=mark.colour, lw=mark.width, ls=DASHES[mark.dash], label=mark.name)
