"""Response time at every duty level, together with the shape of the yield force that all levels share.

The transfer function from the yield force asked for to the yield force delivered (thesis 1.5.3, step 1) is a
first-order lag; its time constant shows where the force follows the turning points of the motion. The lag and
the pre-yield range both delay the force there, so they are estimated together.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from er_models.model import Array, Model
from er_models.prediction import predict_many
from er_models.sensitivity import steps
from scipy.optimize import least_squares

from er_model_lab.fitting.deviations import covariance
from er_model_lab.fitting.fit import Box, Fit
from er_model_lab.identification.part import among, records_of
from er_model_lab.identification.stretches import Level
from er_model_lab.problem.forward import Free
from er_model_lab.problem.problem import Problem

GRID = 12
"""Response times tried first, geometrically from a fifth of a sample to `LONGEST`."""
LONGEST = 0.5
"""Longest response time tried first, as a share of its bound."""
MOST, CLOSE = 60, 1e-7
"""Evaluations of the least squares, and the relative change at which it ends."""


@dataclass(frozen=True)
class Table:
    """Response time at each duty level: duty (m,), tau (m,) [s], covariance (m, m) [s2], NaN at a bound.

    model: the shared shape with deviations; rmse: of the fit [N].
    """

    duty: Array
    tau: Array
    covariance: Array
    model: Model
    rmse: float

    @property
    def sd(self) -> Array:
        """Standard deviations (m,) [s]."""
        return np.asarray(np.sqrt(np.maximum(np.diag(self.covariance), 0.0)))


def response_times(bare: Model, shape: Free, problem: Problem, levels: list[Level]) -> Table:
    """Response time per level and shared shape by bounded least squares, from a model that does not lag.

    Starts from the shape of the model and, per level, from the best of a grid of response times.
    """
    q = bare.catalogue["response"].parameter("tau")
    lagging = bare.with_effect("response", {"tau": q.starts[0] * problem.scales.of(q.unit)})
    box = Box(lagging, (*shape, ("response", "tau")), problem.scales)
    levels_fit = _LevelsFit(box, problem, levels)
    start = levels_fit.start()
    low, high = levels_fit.spread(box.low), levels_fit.spread(box.high)
    edge = 1e-9 * np.minimum(high - low, np.maximum(np.abs(start), 1.0))
    found = least_squares(
        levels_fit.residual, np.clip(start, low + edge, high - edge), levels_fit.jacobian, bounds=(low, high),
        x_scale=np.maximum(np.abs(start), 0.1 * levels_fit.spread(box.size)), xtol=CLOSE, ftol=CLOSE, max_nfev=MOST,
    )  # fmt: skip
    return levels_fit.table(found.x)


class _LevelsFit:
    """Force of all levels as a function of the shared shape followed by one response time per level, all scaled."""

    def __init__(self, box: Box, problem: Problem, levels: list[Level]) -> None:
        self.box, self.problem, self.levels = box, problem, levels
        self.n = len(box.free) - 1
        cut = [records_of(problem.motion, level.rows) for level in levels]
        self.motions = [motion for motion, _ in cut]
        self.inside = [level.rows[rows] for level, (_, rows) in zip(levels, cut, strict=True)]
        self.rows = np.concatenate([np.flatnonzero(level.rows) for level in levels])

    def spread(self, values: Array) -> Array:
        """Values of the box (n + 1,) for the vector of all unknowns (n + m,)."""
        return np.append(values[: self.n], np.full(len(self.levels), values[self.n]))

    def forces(self, points: list[Array]) -> list[Array]:
        """Force (k, rows) of each level at its scaled points (k, n + 1)."""
        found = []
        for motion, inside, at in zip(self.motions, self.inside, points, strict=True):
            found.append(predict_many(self.box.model, self.box.vectors(at), motion)[:, inside])
        return found

    def start(self) -> Array:
        """The shape of the model, and the best response time of the grid per level."""
        shape, top = self.box.start()[: self.n], self.box.high[self.n] * self.box.scale[self.n]
        grid = np.geomspace(0.2 * self.problem.motion.dt, LONGEST * top, GRID)
        points = np.array([np.append(shape, tau) for tau in grid / self.box.scale[self.n]])
        best = [
            points[np.argmin(np.mean((f - self.problem.force[level.rows]) ** 2, axis=1)), self.n]
            for level, f in zip(self.levels, self.forces([points] * len(self.levels)), strict=True)
        ]
        return np.append(shape, best)

    def residual(self, z: Array) -> Array:
        """Predicted minus measured force (rows,) [N]."""
        found = self.forces([np.append(z[: self.n], tau)[None, :] for tau in z[self.n :]])
        return np.asarray(np.concatenate([f[0] for f in found]) - self.problem.force[self.rows])

    def jacobian(self, z: Array) -> Array:
        """Derivative of the force (rows, n + m) by the scaled unknowns."""
        out, at = np.zeros((self.rows.size, z.size)), 0
        own, points = [], []
        for tau in z[self.n :]:
            point = np.append(z[: self.n], tau)
            own.append(step := steps(self.box.parameters, point))
            points.append(np.vstack([point, point + np.diag(step)]))
        for k, (f, step) in enumerate(zip(self.forces(points), own, strict=True)):
            block = slice(at, at + f.shape[1])
            slopes = np.nan_to_num((f[1:] - f[0]).T / step)
            out[block, : self.n], out[block, self.n + k] = slopes[:, : self.n], slopes[:, self.n]
            at = block.stop
        return out

    def table(self, z: Array) -> Table:
        """What was found, with a covariance robust to correlated errors."""
        n, problem = self.n, self.problem
        names = tuple(("response", f"tau at {level.duty:.4g}") for level in self.levels)
        jacobian, residual = np.zeros((problem.motion.n, z.size)), np.zeros(problem.motion.n)
        jacobian[self.rows], residual[self.rows] = self.jacobian(z), -self.residual(z)
        scale = self.spread(self.box.scale)
        near = 1e-6 * self.spread(self.box.size)
        edge = (z <= self.spread(self.box.low) + near) | (z >= self.spread(self.box.high) - near)
        model = self.box.model_at(z[: n + 1])
        fitted = Fit(
            model, (*self.box.free[:n], *names), z, scale, residual, (jacobian,), edge, MOST
        )
        wide = np.maximum(np.abs(z), self.spread(self.box.size))
        spread = covariance(fitted, among(problem, *(level.rows for level in self.levels)), wide)
        sd = np.sqrt(np.maximum(np.diag(spread), 0.0))
        deviations = {k: dict(v) for k, v in model.deviations.items()}
        for (effect, name), value in zip(self.box.free[:n], sd[:n], strict=True):
            deviations.setdefault(effect, {})[name] = float(value)
        shaped = replace(model.without_effect("response"), deviations=deviations)
        duty = np.array([level.duty for level in self.levels])
        rmse = float(np.sqrt(np.mean(residual[self.rows] ** 2)))
        return Table(duty, z[n:] * scale[n:], spread[n:, n:], shaped, rmse)
