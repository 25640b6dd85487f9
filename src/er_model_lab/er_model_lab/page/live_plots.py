"""Figures of a running graph, from what was heard of it last; each replaces that of `plots` of the same name."""

from __future__ import annotations

import numpy as np
from er_models.model import Array

from er_model_lab.filtering import welch
from er_model_lab.live.heard import PLACE, Heard
from er_model_lab.output.report.samples import rms_map
from er_model_lab.output.report.thin import min_max
from er_model_lab.page import plots
from er_model_lab.page.plots import Json, Theme
from er_model_lab.session.sight import TILES

SHOWN = 10.0
"""Time of the curves, loops and spectrum [s]."""
SETTLING = 1.0
"""Time after another model was taken up that is not judged [s]."""
POINTS = 400
"""Points of a curve: what a screen shows of one that moves on."""
LATE = 0.8
"""Share of the course behind which words stand to the left of what they are said of."""
WINDOW = 2.0
"""Time of a point of the error's course [s]."""


def force(heard: Heard, theme: Theme) -> Json:
    """Measured force and that of the monitor's model in the last seconds, and what is left below."""
    rows = heard.last(SHOWN)
    if not len(rows):
        return plots.nothing_yet(theme, "force over time", 400)
    t, f, left = (rows[:, PLACE[name]] for name in ("t", "damper_force", "left"))
    data = [
        plots.line_of(*_thin(t, y), name, colour, width, yaxis=axis)
        for name, y, colour, axis, width in plots.force_curves(theme, f, f - left, left)
    ]
    layout = plots.force_layout(theme, heard.now - SHOWN, heard.now)
    return plots.figure_of(data, layout | {"uirevision": heard.now})


def error(heard: Heard, theme: Theme) -> Json:
    """Size of what is left over all that is remembered, what it should be, and what happened."""
    t, left, usual = (heard.column(name) for name in ("t", "left", "usual"))
    if not t.size:
        return plots.nothing_yet(theme, "live error", 190)
    begin, size = course(t, left, heard.since)
    at = np.searchsorted(t, begin).clip(0, t.size - 1)
    top = float(np.nanmax(size)) if np.isfinite(size).any() else 1.0
    layout = plots.layout_of(theme, 190) | {
        "xaxis": plots.axis_of(theme, "time [s]", range=[t[0], max(heard.now, t[0] + 20.0)]),
        "yaxis": plots.axis_of(theme, "rms [N]", range=[0.0, 1.15 * top]),
        "shapes": [_upright(m.t, theme) for m in heard.marks if m.t >= t[0]],
        "annotations": [
            _word(m.t, m.says, theme, late=m.t > t[0] + LATE * (heard.now - t[0])) for m in heard.marks if m.t >= t[0]
        ],
    }  # fmt: skip
    data = [
        plots.line_of(begin, size, "live error", theme.model, 2.4),
        plots.line_of(
            begin, np.where(usual[at] > 0.0, usual[at], np.nan), "usual", theme.floor, 1.2
        ),
    ]
    return plots.figure_of(data, layout | {"uirevision": heard.now})


def course(t: Array, left: Array, since: float) -> tuple[Array, Array]:
    """Times [s] and rms of what is left [N] in windows, of which none spans the change of the model."""
    begin = np.unique(np.r_[np.arange(t[0], t[-1], WINDOW), since if since > t[0] else t[0]])
    edge = np.searchsorted(t, begin)
    keep = np.diff(edge, prepend=-1) > 0
    begin, edge = begin[keep], edge[keep]
    good = np.isfinite(left)
    count = np.add.reduceat(good.astype(float), edge)
    power = np.add.reduceat(np.where(good, left, 0.0) ** 2, edge)
    with np.errstate(invalid="ignore", divide="ignore"):
        return begin, np.sqrt(power / np.where(count > 0.2 * WINDOW / 0.005, count, np.nan))


def residual_map(heard: Heard, theme: Theme) -> Json:
    """Rms of what is left over velocity and deflection since the model was taken up; it fills while one drives."""
    rows = heard.last(since=heard.since + SETTLING * (heard.since > 0.0))
    v, x, left = (rows[:, PLACE[name]] for name in ("deflection_velocity", "deflection", "left"))
    good = np.isfinite(v) & np.isfinite(x) & np.isfinite(left)
    if np.count_nonzero(good) < 10:
        return plots.nothing_yet(theme, "where it fails", 300)
    edges_v, edges_x, z = rms_map(v[good], x[good], left[good], TILES, 3)
    whole = heard.column("left")
    peak = 2.0 * float(np.sqrt(np.nanmean(whole**2)))  # one scale for the models before and after
    v, x = (np.round(plots.middles(edges), 3) for edges in (edges_v, edges_x))
    tiled = plots.tiles_of(v, x, np.ascontiguousarray(np.round(z, 3)), peak)
    return plots.figure_of([tiled], plots.tiles_layout(theme))


def loops(heard: Heard, theme: Theme) -> Json:
    """Force over velocity of the last seconds, measured and of the model."""
    rows = heard.last(SHOWN)[::5]
    if not len(rows):
        return plots.nothing_yet(theme, "loops", 300)
    v, f, left = (rows[:, PLACE[n]] for n in ("deflection_velocity", "damper_force", "left"))
    data = [
        plots.dots_of(1e3 * v, f, "measured", theme.measured, 3),
        plots.dots_of(1e3 * v, f - left, "model", theme.model, 3),
    ]
    return plots.figure_of(data, plots.loops_layout(theme))


def spectrum(heard: Heard, theme: Theme) -> Json:
    """Amplitude density of what is left in the last seconds."""
    t, left = heard.column("t", SHOWN, heard.since), heard.column("left", SHOWN, heard.since)
    left = np.where(np.isfinite(left), left, 0.0)
    if left.size < 256 or not left.any():
        return plots.nothing_yet(theme, "spectrum", 300)
    f, power = welch(left, (left.size - 1) / (t[-1] - t[0]), 256)
    return plots.spectrum_of(theme, f[1:], np.sqrt(power[1:]))


def _thin(t: Array, y: Array) -> tuple[Array, Array]:
    rows = min_max(y, POINTS)
    return t[rows], y[rows]


def _upright(t: float, theme: Theme) -> Json:
    line = {"color": theme.marked, "width": 1.5, "dash": "dot"}
    return {"type": "line", "x0": t, "x1": t, "y0": 0, "y1": 1, "yref": "paper", "line": line}


def _word(t: float, says: str, theme: Theme, *, late: bool) -> Json:
    font = {"color": theme.marked, "size": 12}
    return {
        "x": t, "y": 1, "yref": "paper", "text": says, "showarrow": False, "yanchor": "top", "font": font,
        "xanchor": "right" if late else "left",
    }  # fmt: skip
