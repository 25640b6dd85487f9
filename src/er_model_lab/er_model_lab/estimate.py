r"""From a fit to estimates: values freed of the bias that noisy motion causes, and standard deviations.

Least squares on measured motion is biased, since the noise of the motion enters the model and its derivatives
alike (errors in variables): a gate 2 mm/s wide looks wider. The bias is simulated: with the fitted model as the
truth along motions x that the sensors may have meant, one Gauss-Newton step says how far the fit along the
fused motion \hat x would move,

.. math:: \delta = (J^T J)^{-1} J^T [f(x) - f(\hat x)]

and the mean of a few draws is taken off (regression calibration: Carroll et al. 2006, ch. 4).
Derivatives are secants over a few hundredths of each value: where a gap closes or a void collapses, the tangent
sees every event by itself and not what many of them do together. There the sum of squares is rough, too: what
two lengths of the secant make of it differs, and that difference is part of the uncertainty.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from er_models.model import Array, Model
from er_models.predict import Motion, predict, predict_many
from er_models.sensitivity import quotients, steps
from numpy.typing import NDArray

from er_model_lab.fit import Box, Fit, covariance
from er_model_lab.motion_error import drawn
from er_model_lab.prepare import Problem

SECANTS = (0.01, 0.03)
"""Steps of a derivative, as shares of the value."""
DRAWS = 6
"""Draws of the motion."""
MOST_BIAS = 4.0
"""Bias that one step can be trusted with, in standard deviations."""
POLISH = 6
"""Most Gauss-Newton steps along secants."""


@dataclass(frozen=True)
class Estimate:
    """Scaled values (p,), their bias that was taken off (p,), and covariance (p, p) [SI]."""

    theta: Array
    bias: Array
    covariance: Array


def secants(
    box: Box, theta: Array, motion: Motion, share: float = SECANTS[0]
) -> tuple[Array, Array]:
    """Force (n,) and its derivative (n, p) by scaled parameters, over a share of each value."""

    def forces(points: Array) -> Array:
        return predict_many(box.model, box.vectors(points), motion)

    here = forces(theta[None])[0]
    return here, quotients(forces, theta, steps(box.parameters, theta, share), here)


def _step(j: Array, e: Array, inner: NDArray[np.bool_]) -> Array:
    """Gauss-Newton step (p,) of the parameters that are not at a bound."""
    out = np.zeros(inner.size)
    out[inner] = np.linalg.lstsq(j[:, inner], e, rcond=1e-10)[0]
    return out


def polished(fitted: Fit, problem: Problem, share: float) -> Fit:
    """The fit moved along secants while that lowers the error, with those derivatives."""
    box, train, theta = Box(fitted.model, fitted.free, problem.scales), problem.train, fitted.theta
    f, j = secants(box, theta, problem.motion, share)
    inner = ~fitted.at_bound
    for _ in range(POLISH):
        e = problem.force - f
        step = _step(j[train], e[train], inner)
        points = np.clip(theta + np.outer((1.0, 0.5, 0.2), step), box.low, box.high)
        forces = predict_many(box.model, box.vectors(points), problem.motion)
        costs = np.mean((problem.force - forces)[:, train] ** 2, axis=1)
        best = int(np.argmin(np.where(np.isfinite(costs), costs, np.inf)))
        if not costs[best] < np.mean(e[train] ** 2) * (1.0 - 1e-6):
            break
        theta = points[best]
        f, j = secants(box, theta, problem.motion, share)
    edge = (theta <= box.low) | (theta >= box.high)
    return replace(
        fitted, model=box.model_at(theta), theta=theta, residual=problem.force - f, jacobian=j,
        at_bound=fitted.at_bound | edge,
    )  # fmt: skip


def estimate(fitted: Fit, problem: Problem, seed: int) -> Estimate:
    """Values without bias and their covariance, of a polished fit."""
    box, rng, train = (
        Box(fitted.model, fitted.free, problem.scales),
        np.random.default_rng(seed),
        problem.train,
    )
    seen, j = secants(box, fitted.theta, problem.motion)
    inner, moves = ~fitted.at_bound, []
    for _ in range(DRAWS):
        f = predict(fitted.model, drawn(problem, rng))
        moves.append(_step(j[train], (f - seen)[train], inner))
    bias, spread = np.mean(moves, axis=0), np.std(moves, axis=0, ddof=1)
    found = covariance(fitted, problem)
    most = MOST_BIAS * np.nan_to_num(np.sqrt(np.maximum(np.diag(found), 0.0)) / fitted.scale)
    bias = np.clip(bias, -most, most)
    theta = np.clip(fitted.theta - bias, box.low, box.high)
    return Estimate(theta, bias, found + np.diag((spread * fitted.scale) ** 2 / DRAWS))


def estimated(fitted: Fit, problem: Problem, seed: int) -> Model:
    """The model with its estimates; a deviation is infinite where the data say nothing."""
    tried = sorted(
        (polished(fitted, problem, share) for share in SECANTS),
        key=lambda f: f.mse(problem.train),
    )
    better = tried[0]
    rough = (tried[1].theta - better.theta) * better.scale
    found = estimate(better, problem, seed)
    model = Box(better.model, better.free, problem.scales).model_at(found.theta)
    deviations = {k: dict(v) for k, v in model.deviations.items()}
    variances = np.diag(found.covariance) + rough**2
    for (effect, name), value in zip(better.free, variances, strict=True):
        sd = float(np.sqrt(value)) if value >= 0 else float("inf")
        deviations.setdefault(effect, {})[name] = sd
    return replace(model, deviations=deviations)
