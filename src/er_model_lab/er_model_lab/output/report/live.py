"""Describes a figure for Plotly: traces and layout as plain JSON, with long curves packed whole.

Curves longer than `MOST_POINTS` travel complete (up to `MOST_KEPT`) as differences of whole
numbers; the page thins them anew for whatever range the reader looks at, so that zooming shows
every sample.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from er_model_lab.output.report.figure import Axis, Figure, Line, Panel
from er_model_lab.output.report.live_marks import Place, draw
from er_model_lab.output.report.palette import INK, MUTED, RULE
from er_model_lab.view import Array

Json = dict[str, Any]

MARGIN = {"l": 62, "r": 16, "t": 44, "b": 46}
GAP = (78.0, 62.0)
"""Space between panels, across and down [px]; a linked figure needs no labels between its rows."""
FONT = {"family": "system-ui, 'Segoe UI', Roboto, Arial, sans-serif", "size": 12, "color": INK}


def live(figure: Figure) -> Json:
    """JSON of one figure: name, data, layout, long (packed curves), whole (range of x)."""
    layout: Json = {
        "height": figure.height, "margin": dict(MARGIN), "font": FONT, "paper_bgcolor": "#fff",
        "plot_bgcolor": "#fff", "shapes": [], "annotations": [], "barmode": "overlay",
        "hovermode": "closest",
        "legend": {"orientation": "h", "x": 0, "y": 1, "yanchor": "top", "yref": "container"},
    }  # fmt: skip
    out: Json = {"name": figure.name, "data": [], "layout": layout, "long": [], "packed": []}
    named: set[str] = set()
    kept: list[Array] = []
    for k, panel in enumerate(figure.panels):
        place = Place(out, k, named, kept)
        _axes(figure, panel, k, layout)
        for mark in panel.marks:
            draw(mark, place)
    if figure.scale:
        layout["margin"]["r"] = 96
        layout["coloraxis"] = {
            "cmin": figure.scale.low, "cmax": figure.scale.high, "colorscale": figure.scale.stops,
            "colorbar": {"title": {"text": figure.scale.label, "side": "right"}, "thickness": 12,
            "outlinewidth": 0},
        }  # fmt: skip
    if figure.linked:
        out["whole"] = _whole(figure)
    return out


def _axes(figure: Figure, panel: Panel, k: int, layout: Json) -> None:
    """The two axes of panel k and its title."""
    across, down = _domain(figure, k)
    n = "" if k == 0 else str(k + 1)
    below = k + figure.columns >= len(figure.panels)
    x, y = _axis(panel.x, across, f"y{n}"), _axis(panel.y, down, f"x{n}")
    if figure.linked:
        x["showticklabels"] = below
        if k:
            x["matches"] = "x"
        if not below:
            x["title"] = {"text": ""}
    layout[f"xaxis{n}"], layout[f"yaxis{n}"] = x, y
    if panel.title:
        layout["annotations"].append(
            {"text": f"<b>{panel.title}</b>", "xref": f"x{n} domain", "yref": f"y{n} domain",
            "x": 0, "y": 1,
             "xanchor": "left", "yanchor": "bottom", "showarrow": False, "font": {"size": 12}}
        )  # fmt: skip


def _axis(axis: Axis, domain: tuple[float, float], anchor: str) -> Json:
    """One axis in Plotly's words."""
    out: Json = {
        "domain": domain, "anchor": anchor, "title": {"text": axis.label, "standoff": 8},
        "gridcolor": RULE,
        "zerolinecolor": "#b8c0ca", "linecolor": MUTED, "showline": True, "tickcolor": MUTED,
        "ticks": "outside", "ticklen": 4, "automargin": True,
    }  # fmt: skip
    if axis.span:
        out["range"] = [float(np.log10(v)) for v in axis.span] if axis.log else list(axis.span)
    if axis.log:
        out |= {"type": "log", "tickformat": "~g", "dtick": "D2"}
    if axis.ticks:
        out |= {
            "tickvals": [at for at, _ in axis.ticks], "tickangle": 0, "showgrid": False,
            "zeroline": False,
            "ticktext": [text.replace("\n", "<br>") for _, text in axis.ticks], "ticks": "",
            "tickfont": {"size": 10 if len(axis.ticks) > 5 and anchor.startswith("y") else 12},
        }  # fmt: skip
    return out


def _domain(figure: Figure, k: int) -> tuple[tuple[float, float], tuple[float, float]]:
    """Where panel k stands in the plot area, (left, right) and (bottom, top), 0..1."""
    row, column = divmod(k, figure.columns)
    inner_width = figure.width - MARGIN["l"] - MARGIN["r"]
    inner_height = figure.height - MARGIN["t"] - MARGIN["b"]
    gap = GAP[0] / inner_width
    width = (1.0 - gap * (figure.columns - 1)) / figure.columns
    left = column * (width + gap)
    rise = (24.0 if figure.linked else GAP[1]) / inner_height
    room = 1.0 - rise * (figure.rows - 1)
    top = 1.0 - sum(figure.shares[:row]) * room - row * rise
    return (left, min(left + width, 1.0)), (max(top - figure.shares[row] * room, 0.0), top)


def _whole(figure: Figure) -> list[float]:
    """Smallest and largest x of all curves."""
    xs = [mark.x for panel in figure.panels for mark in panel.marks if isinstance(mark, Line)]
    return [float(min(np.nanmin(x) for x in xs)), float(max(np.nanmax(x) for x in xs))]
