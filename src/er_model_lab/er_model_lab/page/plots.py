"""Figures of the page as Plotly takes them, from what a desk shows; nothing here knows the framework."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from er_models.model import Array
from numpy.typing import NDArray

from er_model_lab.output.report.live import live
from er_model_lab.output.report.palette import ERROR, HELD_OUT
from er_model_lab.output.report.thin import every, stretches
from er_model_lab.session.desk import Desk
from er_model_lab.session.fall import Stage
from er_model_lab.session.sight import (
    ON_SCREEN,
    Selection,
    Sight,
    curve,
    loops,
    spectrum,
    tile_map,
)

Json = dict[str, Any]


@dataclass(frozen=True)
class Theme:
    """Colours of a light or dark page; every pair has contrast AA on the page's ground."""

    ink: str
    rule: str
    measured: str
    model: str
    left: str
    marked: str
    held: str
    floor: str
    warning: str
    fail: str


LIGHT = Theme(
    "#1f2933",
    "#d9dee5",
    "#2b2b2b",
    "#c24f00",
    "#0072b2",
    "#9c4a7c",
    HELD_OUT,
    "#007a58",
    "#b98a00",
    "#a33f00",
)
DARK = Theme(
    "#e6e9ee",
    "#3a424d",
    "#dfe3e8",
    "#ff9a4d",
    "#63b9ea",
    "#e79cc6",
    "#6a5c1c",
    "#3fcf9f",
    "#e9b44c",
    "#ff5e3a",
)
DOTS = 400
"""Samples of a force over velocity that are drawn where they are too many to be joined."""
MARKED = 400
"""Samples of a tile that are marked in time."""
MOST_SHADED = 200
"""Stretches of one kind that are shaded."""
CONFIG: Json = {
    "displaylogo": False, "showTips": False, "responsive": True, "scrollZoom": False, "displayModeBar": "hover",
    "modeBarButtonsToRemove": ["sendDataToCloud", "lasso2d", "select2d", "autoScale2d", "toImage"],
}  # fmt: skip


HOLDING: Json = {"dragmode": "select", "selectdirection": "h", "selections": []}
"""Layout of the curves while dragging over them holds out."""


def force(desk: Desk, theme: Theme) -> Json:
    """Measured and predicted force over time, and what is left below, of the seconds in view."""
    sight, predicted = desk.sight, desk.predicted
    if sight is None or predicted is None:
        return nothing_yet(theme, "force over time", 400)
    seconds = desk.selection.seconds
    rows = force_curves(theme, sight.force, predicted, sight.force - predicted)
    if (laid := desk.laid) is not None:
        rows.insert(1, (desk.beside, laid, theme.marked, "y", 1.0))
    data = [
        line_of(*curve(sight, y, seconds), name, colour, width, yaxis=axis)
        for name, y, colour, axis, width in rows
    ]
    if desk.selection.velocity is not None:
        at = _marked(desk, sight)
        data.append(dots_of(sight.t[at], sight.force[at], "in the tile", theme.marked))
    layout = force_layout(theme, *(seconds or sight.ends))
    return figure_of(
        data,
        layout | {"shapes": [*_held(sight, theme), *_found(sight, theme)], "dragmode": "zoom"},
    )


def force_curves(
    theme: Theme, measured: Array, predicted: Array, left: Array
) -> list[tuple[str, Array, str, str, float]]:
    """Name, values, colour, axis and width of the curves of a force over time."""
    return [
        ("measured", measured, theme.measured, "y", 2.4), ("model", predicted, theme.model, "y", 1.4),
        ("measured \N{MINUS SIGN} model", left, theme.left, "y2", 1.1),
    ]  # fmt: skip


def force_layout(theme: Theme, begin: float, end: float) -> Json:
    """Force over time [s] above, what is left below."""
    return layout_of(theme, 400) | {
        "xaxis": axis_of(theme, "time [s]", range=[begin, end], anchor="y2"),
        "yaxis": axis_of(theme, "force [N]", domain=[0.40, 1.0]),
        "yaxis2": axis_of(theme, "left [N]", domain=[0.0, 0.33], anchor="x"), "hovermode": "x",
    }  # fmt: skip


def _marked(desk: Desk, sight: Sight) -> NDArray[np.int64]:
    """Rows of the selected samples, no more than can be seen apart."""
    at = np.flatnonzero(desk.selection.mask(sight))
    return at[every(at.size, MARKED)] if at.size else at


def _held(sight: Sight, theme: Theme) -> list[Json]:
    """Shaded where data only score."""
    spans = [
        s for p in sight.parts for s in stretches(sight.t[p.i : p.j], sight.problem.held_out[p.i : p.j])
    ]  # fmt: skip
    return _shaded(spans, "held out", theme.held, 0.0, "73")


def _found(sight: Sight, theme: Theme) -> list[Json]:
    """Coloured where the data were found to be wrong, the worst in front."""
    colours = {"note": theme.ink, "warning": theme.warning, "fail": theme.fail}
    return [
        shape for level, colour in colours.items()
        for shape in _shaded(
            [s for f in sight.preflight.findings if f.level == level for s in sight.places(f)],
            level, colour, 2.0, "4d",
        )
    ]  # fmt: skip


def _shaded(
    spans: Sequence[tuple[float, float]], name: str, colour: str, edge: float, strength: str
) -> list[Json]:
    """Rectangles from top to bottom, told once.

    edge: width of their lines [px], so that a short one is seen, too; strength: of the colour within, 00 to ff.
    """
    return [
        {
            "type": "rect", "x0": a, "x1": b, "y0": 0, "y1": 1, "xref": "x", "yref": "paper", "layer": "below",
            "line": {"width": edge, "color": colour}, "fillcolor": colour + strength,
            "name": name, "showlegend": k == 0,
        }
        for k, (a, b) in enumerate(spans[:MOST_SHADED])
    ]  # fmt: skip


def residual_map(desk: Desk, theme: Theme) -> Json:
    """Rms of what is left over velocity and deflection, of the seconds in view."""
    sight, residual = desk.sight, desk.residual
    if sight is None or residual is None:
        return nothing_yet(theme, "where it fails", 300)
    at = desk.selection
    seconds = (
        None if at.seconds is None else (sight.t >= at.seconds[0]) & (sight.t <= at.seconds[1])
    )
    z, tiles = tile_map(sight, residual, seconds, 5 if seconds is None else 1), sight.tiles
    peak = float(np.nanquantile(z, 0.99)) if np.isfinite(z).any() else 1.0
    tiled = tiles_of(middles(tiles.v), middles(tiles.x), np.round(z, 4), peak)
    layout = tiles_layout(theme)
    if at.velocity is not None and at.deflection is not None:
        (a, b), (c, d) = at.velocity, at.deflection
        layout["shapes"] = [{
            "type": "rect", "x0": 1e3 * a, "x1": 1e3 * b, "y0": 1e3 * c, "y1": 1e3 * d,
            "line": {"color": theme.ink, "width": 3},
        }]  # fmt: skip
    return figure_of([tiled], layout)


def middles(edges: Array) -> Array:
    """Middles of tiles [mm, mm/s] from their edges [m, m/s]."""
    return np.asarray(1e3 * (edges[1:] + edges[:-1]) / 2)


def tiles_of(v: Array, x: Array, z: Array, peak: float) -> Json:
    """Rms z [N] over velocity [mm/s] and deflection [mm]; peak: end of the colours [N]."""
    return {
        "type": "heatmap", "x": v, "y": x, "z": z, "zmin": 0.0, "zmax": peak, "colorscale": ERROR, "hoverongaps": False,
        "colorbar": {"title": {"text": "rms [N]", "side": "right"}, "thickness": 10, "outlinewidth": 0},
        "hovertemplate": "%{x:.0f} mm/s, %{y:.1f} mm: %{z:.3g} N<extra></extra>",
    }  # fmt: skip


def tiles_layout(theme: Theme) -> Json:
    """Axes of such a map."""
    return layout_of(theme, 300) | {
        "xaxis": axis_of(theme, "velocity [mm/s]", zeroline=False),
        "yaxis": axis_of(theme, "deflection [mm]", zeroline=False),
    }


def force_loops(desk: Desk, theme: Theme) -> Json:
    """Force over velocity, measured and predicted, of the seconds in view; the selected tile is marked."""
    sight, predicted = desk.sight, desk.predicted
    if sight is None or predicted is None:
        return nothing_yet(theme, "loops", 300)
    mask = Selection(desk.selection.seconds).mask(sight)
    joined = int(mask.sum()) <= ON_SCREEN
    v, forces = loops(sight, [sight.force, predicted], mask, ON_SCREEN if joined else DOTS)
    both = zip(("measured", "model"), forces, (theme.measured, theme.model), strict=True)
    data = [
        line_of(1e3 * v, y, name, colour, 1.2) if joined else dots_of(1e3 * v, y, name, colour, 3)
        for name, y, colour in both
    ]
    if desk.selection.velocity is not None:
        at = _marked(desk, sight)
        data.append(
            dots_of(1e3 * sight.problem.motion.v[at], sight.force[at], "in the tile", theme.marked)
        )
    return figure_of(data, loops_layout(theme))


def loops_layout(theme: Theme) -> Json:
    """Axes of force over velocity."""
    return layout_of(theme, 300) | {
        "xaxis": axis_of(theme, "velocity [mm/s]"), "yaxis": axis_of(theme, "force [N]"), "hovermode": "closest",
    }  # fmt: skip


def residual_spectrum(desk: Desk, theme: Theme) -> Json:
    """Amplitude density of what is left, of what is selected."""
    sight, residual = desk.sight, desk.residual
    if sight is None or residual is None:
        return nothing_yet(theme, "spectrum", 300)
    return spectrum_of(theme, *spectrum(sight, residual, desk.selection.mask(sight)))


def spectrum_of(theme: Theme, f: Array, density: Array) -> Json:
    """Amplitude density [N/sqrt(Hz)] over frequency [Hz]."""
    layout = layout_of(theme, 300) | {
        "xaxis": axis_of(theme, "frequency [Hz]", type="log", tickformat="~g", dtick="D2"),
        "yaxis": axis_of(theme, "left [N/\N{SQUARE ROOT}Hz]", type="log", tickformat="~g", dtick="D2"),
    }  # fmt: skip
    return figure_of([line_of(f, density, "left", theme.left, 1.4)], layout)


def waterfall(fall: list[Stage], floor: float | None, theme: Theme) -> Json:
    """The error of the model as given and after each step, of measured terms in a colour of their own."""
    places, names = list(range(len(fall))), [stage.says for stage in fall]
    sides = [
        ("learnt from", [s.errors.train for s in fall], theme.left, 0.6),
        ("held out", [s.errors.held_out for s in fall], theme.model, 1.0),
    ]
    data: list[Json] = []
    for measured in dict.fromkeys([False, *(s.measured for s in fall)]):
        at = [k for k in places if fall[k].measured == measured]
        for name, y, colour, opacity in sides:
            look = {"color": theme.marked, "opacity": opacity} if measured else {"color": colour}
            data.append({
                "type": "bar", "x": at, "y": [y[k] for k in at], "offsetgroup": name, "marker": look,
                "name": f"measured term, {name}" if measured else name,
            })  # fmt: skip
    layout = layout_of(theme, 280) | {
        "barmode": "group", "xaxis": axis_of(theme, "", tickvals=places, ticktext=names),
        "yaxis": axis_of(theme, "rms error [N]", rangemode="tozero"),
    }  # fmt: skip
    if floor is not None:
        layout["shapes"] = [{
            "type": "line", "xref": "paper", "x0": 0, "x1": 1, "y0": floor, "y1": floor,
            "line": {"color": theme.floor, "dash": "dash"},
            "label": {"text": f"noise {floor:.3g} N", "font": {"color": theme.floor}, "textposition": "end"},
        }]  # fmt: skip
    return figure_of(data, layout)


def of_report(figure: Any, theme: Theme) -> Json:
    """A figure of the report in the colours of the page."""
    drawn = live(figure)
    layout = drawn["layout"] | {
        "paper_bgcolor": "rgba(0,0,0,0)", "plot_bgcolor": "rgba(0,0,0,0)", "font": {"color": theme.ink, "size": 12},
    }  # fmt: skip
    for key, axis in layout.items():
        if key.startswith(("xaxis", "yaxis")):
            axis |= {"gridcolor": theme.rule, "zerolinecolor": theme.rule}
    return figure_of(drawn["data"], layout)


def line_of(x: Array, y: Array, name: str, colour: str, width: float, **more: Any) -> Json:
    """A curve."""
    line = {"color": colour, "width": width}
    return {
        "x": np.round(x, 4),
        "y": np.round(y, 5),
        "mode": "lines",
        "name": name,
        "line": line,
        **more,
    }


def dots_of(x: Array, y: Array, name: str, colour: str, size: float = 6) -> Json:
    """Points."""
    return {
        "x": np.round(x, 4),
        "y": np.round(y, 5),
        "mode": "markers",
        "name": name,
        "marker": {"color": colour, "size": size},
    }


def axis_of(theme: Theme, label: str, **more: Any) -> Json:
    """An axis in the colours of the page."""
    return {
        "title": {"text": label, "standoff": 6}, "gridcolor": theme.rule, "zerolinecolor": theme.rule,
        "automargin": True, **more,
    }  # fmt: skip


def layout_of(theme: Theme, height: int) -> Json:
    """What all figures have."""
    return {
        "height": height, "margin": {"l": 54, "r": 12, "t": 28, "b": 40}, "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)", "font": {"color": theme.ink, "size": 12}, "uirevision": "kept",
        "legend": {"orientation": "h", "x": 0, "y": 1, "yref": "container", "yanchor": "top"}, "showlegend": True,
    }  # fmt: skip


def nothing_yet(theme: Theme, what: str, height: int) -> Json:
    """A figure without data."""
    layout = layout_of(theme, height) | {"xaxis": {"visible": False}, "yaxis": {"visible": False}}
    layout["annotations"] = [
        {"text": f"{what}: no data yet", "showarrow": False, "font": {"size": 14}}
    ]
    return figure_of([], layout)


def figure_of(data: list[Json], layout: Json) -> Json:
    """A whole figure."""
    return {"data": data, "layout": layout, "config": CONFIG}
