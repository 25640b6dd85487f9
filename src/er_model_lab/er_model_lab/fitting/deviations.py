"""How sure fitted values are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from er_models.model import Array, Model

from er_model_lab.fitting.fit import Fit, mean_square
from er_model_lab.problem.problem import Problem

NOTHING = 1e-9
"""A parameter that moves the force by so small a share of the strongest one is not told by the data."""


def widths(fitted: Fit) -> Array:
    """How far values (p,) may lie from where they are before any data: as much as they are large; scaled."""
    catalogue = fitted.model.catalogue
    sizes = np.array([catalogue[e].parameter(q).size for e, q in fitted.free])
    return np.asarray(np.maximum(np.abs(fitted.theta), sizes))


def covariance(fitted: Fit, problem: Problem, wide: Array | None = None) -> Array:
    """Covariance (p, p) of the parameters [SI], robust to correlated errors: sandwich over one-second blocks.

    Values that make up for each other wholly (a share and the width of a play between two levels) are known no better
    than before the data: to `wide` (p,), scaled, or `widths`. NaN where the model predicts no numbers.
    """
    train = np.flatnonzero(problem.train)
    inner = np.flatnonzero(~fitted.at_bound)
    j, r = fitted.jacobian[train][:, inner], fitted.residual[train]
    left = mean_square(r)
    if not np.isfinite(left):
        return np.full((fitted.theta.size,) * 2, np.nan)
    wide = widths(fitted) if wide is None else wide
    before = np.diag(left / wide[inner] ** 2)
    inverse = np.linalg.pinv(j.T @ j + before, rcond=1e-15)
    length = problem.second
    blocks = train // length
    edges = np.flatnonzero(np.diff(blocks)) + 1
    scores = np.add.reduceat(j * r[:, None], np.concatenate([[0], edges]), axis=0)
    m = scores.shape[0]
    meat = scores.T @ scores * (m / max(m - inner.size, 1)) + before * left
    out = np.full((fitted.theta.size,) * 2, np.nan)
    out[np.ix_(inner, inner)] = (
        inverse @ meat @ inverse * np.outer(fitted.scale[inner], fitted.scale[inner])
    )
    return out


def standard_deviations(fitted: Fit, problem: Problem) -> Array:
    """Standard deviations (p,) of the parameters [SI]; infinite where the data say nothing."""
    variance = np.diag(covariance(fitted, problem))
    size = np.linalg.norm(
        fitted.jacobian[problem.train], axis=0
    )  # the pseudo-inverse calls what moves nothing exact
    told = (variance >= 0.0) & (size > NOTHING * size.max(initial=0.0))
    return np.asarray(np.sqrt(np.where(told, variance, np.inf)))


def with_deviations(fitted: Fit, problem: Problem) -> Model:
    """The fitted model with standard deviations; one that was summed up has them."""
    if not fitted.columns[0].shape[0]:
        return fitted.model
    deviations = {k: dict(v) for k, v in fitted.model.deviations.items()}
    for (effect, name), sd in zip(fitted.free, standard_deviations(fitted, problem), strict=True):
        deviations.setdefault(effect, {})[name] = float(sd)
    return replace(fitted.model, deviations=deviations)
