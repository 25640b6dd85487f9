"""How Plotly draws each kind of mark: a trace, a shape or an annotation."""

from __future__ import annotations

from dataclasses import dataclass
from functools import singledispatch
from typing import Any

import numpy as np

from er_model_lab.output.report.figure import Band, Bars, Label, Level, Line, Points, Spans, Tiles
from er_model_lab.output.report.palette import INK, MUTED
from er_model_lab.output.report.thin import MOST_POINTS, min_max
from er_model_lab.view import Array

Json = dict[str, Any]

MOST_KEPT = 130_000
"""Samples of one curve that travel in the page; beyond, it is thinned before."""
STEPS = 8000
"""Steps from the lowest to the highest value of a packed curve that has no coarser grain."""
HOVER = "%{x:.4g}, %{y:.4g}"


@dataclass(frozen=True)
class Place:
    """Where a mark goes: the figure's JSON, the panel, names in the legend, arrays packed."""

    out: Json
    panel: int
    named: set[str]
    kept: list[Array]

    @property
    def n(self) -> str:
        """Suffix of the panel's axes."""
        return "" if self.panel == 0 else str(self.panel + 1)

    def legend(self, name: str) -> Json:
        """Legend entries of a mark: each name is listed once for the whole figure."""
        fresh = bool(name) and name not in self.named
        self.named.add(name)
        return {"name": name, "legendgroup": name, "showlegend": fresh}

    def trace(self, fields: Json) -> None:
        """Add a trace on the panel's axes."""
        self.out["data"].append({"xaxis": f"x{self.n}", "yaxis": f"y{self.n}", **fields})

    def shape(self, name: str, fields: Json) -> None:
        """Add a shape below the curves."""
        self.out["layout"]["shapes"].append({"layer": "below", **self.legend(name), **fields})

    def pack(self, y: Array, grain: float = 0.0) -> int:
        """Number of the packed array; the same array, like a common time axis, is packed once."""
        for k, known in enumerate(self.kept):
            if known is y:
                return k
        self.kept.append(y)
        self.out["packed"].append(packed(y, grain))
        return len(self.kept) - 1


def plain(y: Array) -> list[float | None]:
    """Values with five digits; what is not finite becomes null."""
    return [float(f"{v:.5g}") if np.isfinite(v) else None for v in y]


def packed(y: Array, grain: float = 0.0) -> Json:
    """Array y (n,) as start, step and differences of whole steps; null where it is not finite.

    What rises all the time is a time axis: a quarter of its sample time is the step.
    """
    good = np.isfinite(y)
    values = y[good]
    rises = np.diff(values)
    low, step = 0.0, 1.0
    if values.size:
        time = rises.size > 0 and float(rises.min()) > 0
        low = float(values.min())
        step = (
            float(np.median(rises)) / 4.0
            if time
            else max(float(np.ptp(values)) / STEPS, grain, 1e-300)
        )
    differences = np.diff(np.round((values - low) / step).astype(np.int64), prepend=0)
    out: list[int | None] = [None] * y.size
    for row, value in zip(np.flatnonzero(good).tolist(), differences.tolist(), strict=True):
        out[row] = value
    return {"low": low, "step": step, "rises": out}


@singledispatch
def draw(mark: object, _: Place) -> None:
    """Add one mark to the figure; `TypeError` for anything that is no mark."""
    raise TypeError(f"{type(mark).__name__} is no mark")


@draw.register
def _line(mark: Line, place: Place) -> None:
    x, y = mark.x, mark.y
    trace: Json = {
        "type": "scatter", "mode": "lines", "hovertemplate": HOVER + f"<extra>{mark.name}</extra>",
        "line": {"color": mark.colour, "width": mark.width, "dash": mark.dash},
        **place.legend(mark.name),
    }  # fmt: skip
    if y.size <= MOST_POINTS:
        place.trace(trace | {"x": plain(x), "y": plain(y)})
        return
    if y.size > MOST_KEPT:
        rows = min_max(y, MOST_KEPT)
        x, y = x[rows], y[rows]
    # drawn by the page, which knows the range in view
    place.out["long"].append(
        {"trace": len(place.out["data"]), "x": place.pack(x), "y": place.pack(y, mark.grain)}
    )
    place.trace(trace | {"x": [], "y": []})


@draw.register
def _points(mark: Points, place: Place) -> None:
    marker: Json = {"size": mark.size, "opacity": mark.alpha}
    if isinstance(mark.colour, str):
        marker["color"] = mark.colour
    else:
        marker |= {"color": plain(mark.colour), "coloraxis": "coloraxis"}
    place.trace({
        "type": "scatter", "mode": "markers", "marker": marker, "x": plain(mark.x),
        "y": plain(mark.y),
        "hovertemplate": HOVER + f"<extra>{mark.name}</extra>", **place.legend(mark.name),
    })  # fmt: skip


@draw.register
def _bars(mark: Bars, place: Place) -> None:
    across, along = ("y", "x") if mark.horizontal else ("x", "y")
    trace: Json = {
        "type": "bar", "orientation": "h" if mark.horizontal else "v", across: plain(mark.at),
        along: plain(mark.size), "width": mark.width, "marker": {"color": list(mark.colours)},
        "hovertemplate": f"%{{{along}:.4g}}<extra>{mark.name}</extra>", **place.legend(mark.name),
    }  # fmt: skip
    if mark.base is not None:
        trace["base"] = plain(mark.base)
    if mark.text:
        trace |= {"text": list(mark.text), "textposition": "outside", "cliponaxis": False}
    if mark.ends is not None:
        tip = mark.size if mark.base is None else mark.base + mark.size
        trace[f"error_{along}"] = {
            "type": "data", "symmetric": False, "array": plain(np.clip(mark.ends[1] - tip, 0,
            None)),
            "arrayminus": plain(np.clip(tip - mark.ends[0], 0, None)), "color": INK,
            "thickness": 1, "width": 3,
        }  # fmt: skip
    place.trace(trace)


@draw.register
def _tiles(mark: Tiles, place: Place) -> None:
    place.trace({
        "type": "heatmap", "x": plain(mark.x_edges), "y": plain(mark.y_edges),
        "z": [plain(row) for row in mark.z],
        "coloraxis": "coloraxis", "hoverongaps": False,
        "hovertemplate": "%{x:.4g}, %{y:.4g}: %{z:.3g}<extra></extra>",
    })  # fmt: skip


@draw.register
def _band(mark: Band, place: Place) -> None:
    place.shape(mark.name, {
        "type": "rect", "xref": f"x{place.n} domain", "yref": f"y{place.n}", "x0": 0, "x1": 1,
        "y0": mark.low,
        "y1": mark.high, "fillcolor": mark.colour, "opacity": 0.16, "line": {"width": 0},
    })  # fmt: skip


@draw.register
def _spans(mark: Spans, place: Place) -> None:
    for low, high in mark.stretches:
        place.shape(mark.name, {
            "type": "rect", "xref": f"x{place.n}", "yref": f"y{place.n} domain", "x0": low,
            "x1": high, "y0": 0,
            "y1": 1, "fillcolor": mark.colour, "opacity": 0.4, "line": {"width": 0},
        })  # fmt: skip


@draw.register
def _level(mark: Level, place: Place) -> None:
    along, across = ("y", "x") if mark.vertical else ("x", "y")
    place.shape(mark.name, {
        "type": "line", f"{along}ref": f"{along}{place.n} domain",
        f"{across}ref": f"{across}{place.n}",
        f"{along}0": 0, f"{along}1": 1, f"{across}0": mark.value, f"{across}1": mark.value,
        "layer": "above",
        "line": {"color": mark.colour, "width": 1.6, "dash": mark.dash},
    })  # fmt: skip


@draw.register
def _label(mark: Label, place: Place) -> None:
    place.out["layout"]["annotations"].append(
        {"text": mark.text, "xref": f"x{place.n}", "yref": f"y{place.n} domain", "x": mark.x,
        "y": 1,
         "xanchor": "left", "yanchor": "bottom", "showarrow": False, "font": {"size": 11,
         "color": MUTED}}
    )  # fmt: skip
