"""How long the data stay in each part of a plane: deflection and velocity, velocity and duty, and lines of others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from er_records.record import Array

from er_model_lab.preflight.excitation import Course, Reach

PARTS, LINE = 12, 9
"""Parts of each axis of a plane, and of a line."""


@dataclass(frozen=True, eq=False)
class CoverMap:
    """Seconds (rows, columns) over edges of x (columns + 1,) and y (rows + 1,), SI; a line has one row and no y."""

    x: str
    x_unit: str
    x_edges: Array
    y: str
    y_unit: str
    y_edges: Array
    seconds: Array

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "x": self.x, "x_unit": self.x_unit, "x_edges": self.x_edges.tolist(),
            "y": self.y, "y_unit": self.y_unit, "y_edges": self.y_edges.tolist(), "seconds": self.seconds.tolist(),
        }  # fmt: skip


def maps(courses: Sequence[Course], reach: Reach) -> tuple[CoverMap, ...]:
    """Planes and lines that the data span."""
    x, v, u = (np.concatenate([getattr(c, k) for c in courses]) for k in "xvu")
    w = np.concatenate([np.full(c.x.size, c.dt) for c in courses])
    found = []
    span_x, span_v = _both(reach.deflection), _both(reach.velocity)
    if reach.deflection > 0.0 and reach.velocity > 0.0:
        found.append(_plane("velocity", "m/s", v, span_v, "deflection", "m", x, span_x, w))
    if reach.duty > 0.0 and reach.velocity > 0.0:
        span_u = np.linspace(0.0, reach.duty, PARTS + 1)
        found.append(_plane("velocity", "m/s", v, span_v, "duty", "1", u, span_u, w))
        rate = np.concatenate([np.diff(c.u, prepend=c.u[0]) / c.dt for c in courses])
        if np.any(rate != 0.0):
            most = float(np.abs(rate).max())
            found.append(_line("duty rate", "1/s", rate, np.linspace(-most, most, LINE + 1), w))
    theta = np.concatenate([c.theta for c in courses])
    theta, wt = theta[np.isfinite(theta)], w[np.isfinite(theta)]
    if theta.size and np.ptp(theta) > 0.0:
        span = np.linspace(float(theta.min()), float(theta.max()), LINE + 1)
        found.append(_line("temperature", "K", theta, span, wt))
    return tuple(found)


def _both(reach: float) -> Array:
    """Edges from minus to plus a reach."""
    return np.linspace(-reach, reach, PARTS + 1)


def _plane(
    x: str, x_unit: str, xs: Array, x_edges: Array, y: str, y_unit: str, ys: Array, y_edges: Array, w: Array
) -> CoverMap:  # fmt: skip
    """Time over a plane; what lies outside counts to the edge."""
    good = np.isfinite(xs) & np.isfinite(ys)
    xs, ys = (
        np.clip(xs[good], x_edges[0], x_edges[-1]),
        np.clip(ys[good], y_edges[0], y_edges[-1]),
    )
    seconds, _, _ = np.histogram2d(ys, xs, (y_edges, x_edges), weights=w[good])
    return CoverMap(x, x_unit, x_edges, y, y_unit, y_edges, np.asarray(seconds))


def _line(x: str, unit: str, xs: Array, edges: Array, w: Array) -> CoverMap:
    """Time over one quantity."""
    seconds, _ = np.histogram(np.clip(xs, edges[0], edges[-1]), edges, weights=w)
    return CoverMap(x, unit, edges, "", "", np.zeros(0), np.asarray(seconds)[None])
