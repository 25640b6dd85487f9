"""What a fitted model predicts of each block of its data without it: one linear solve a block instead of a refit."""

from __future__ import annotations

import numpy as np
from er_models.model import Array

from er_model_lab.fitting.fit import DAMPED, NEAR, Box, Fit, about, mean_square
from er_model_lab.problem.problem import Problem

DOUBTFUL = 1.1
"""Mean square without each block, over that of the fit, above which a straight line is not believed."""
SHARES = np.array([0.1, 0.3])
"""Shares of a step that are tried, beside all and none of it, where it is not."""


def cross_validated(
    fitted: Fit, problem: Problem, *, straight: bool = False
) -> tuple[Array, Array]:
    """Residual (n,) predicted without each block, and mean squared error per block (blocks,).

    One Gauss-Newton step from the full fit leaves a block out: (H - H_b) d = g - g_b. Where the straight line
    of that step would rather be a jump (a gap that closes, a void that collapses), the model itself predicts
    the block, from as much of the step as lowers the error of the other blocks. Refinements stay as they are then: the
    few blocks that show them would be held against the effect. straight: the line is believed. Where a record's states
    begin is told by its own samples: the error is raised by what each such number gains by chance.
    """
    steps = _leaving_out(fitted, problem, damping=DAMPED if straight else 0.0)
    r, j = fitted.residual.copy(), fitted.jacobian
    blocks = range(int(problem.fold.max()) + 1)
    for b in blocks:
        rows = problem.fold == b
        r[rows] = fitted.residual[rows] - j[rows] @ steps[b]
    train = problem.train
    if not straight and np.mean(r[train] ** 2) > DOUBTFUL * fitted.mse(train):
        r = _truly_left_out(fitted, problem, _leaving_out(fitted, problem, refined=False))
    told, n = problem.forward.beginnings(problem, fitted.model), int(train.sum())
    r[train] *= np.sqrt((n + told) / max(n - told, 1.0))
    losses = [float(np.mean(r[problem.fold == b] ** 2)) for b in blocks]
    return r, np.array(losses)


def _leaving_out(
    fitted: Fit, problem: Problem, *, refined: bool = True, damping: float = 0.0
) -> Array:
    """Change of the scaled parameters (blocks, p) when a block is left out; refined: of refinements, too.

    damping: share of their curvature by which they are held.
    """
    catalogue = fitted.model.catalogue
    form = [catalogue[e].parameter(q).optional for e, q in fitted.free]
    inner = ~fitted.at_bound & (refined | ~np.array(form, bool))
    j_all, train = fitted.jacobian[:, inner], problem.train
    h = j_all[train].T @ j_all[train]
    ridge = 1e-10 * np.trace(h) / max(h.shape[0], 1) * np.eye(h.shape[0])
    held = ridge + damping * np.diag(np.diag(h))
    g = j_all[train].T @ fitted.residual[train]
    steps = np.zeros((int(problem.fold.max()) + 1, inner.size))
    for b in range(steps.shape[0]):
        rows = problem.fold == b
        j, e = j_all[rows], fitted.residual[rows]
        if j.shape[1]:
            steps[b, inner] = np.linalg.solve(h - j.T @ j + held, g - j.T @ e)
    return steps


def _truly_left_out(fitted: Fit, problem: Problem, steps: Array) -> Array:
    """Residual (n,) predicted by the model itself without each block."""
    box = Box(fitted.model, fitted.free, problem.scales, problem.forward.limits)
    r, train = fitted.residual.copy(), problem.train
    near = about(fitted, problem).begun(fitted.model)

    def moved(shares: Array, step: Array) -> Array:
        points = np.clip(fitted.theta + np.multiply.outer(shares, step), box.low, box.high)
        return problem.force - near.predict_many(box.model, box.vectors(points))

    for b in range(steps.shape[0]):
        rows, others = problem.fold == b, train & (problem.fold != b)
        left = np.concatenate([fitted.residual[None], moved(np.ones(1), steps[b])])
        straight = fitted.residual[others] - fitted.jacobian[others] @ steps[b]
        here, there = mean_square(left[0, others]), mean_square(left[1, others])
        if not here - there > NEAR * (here - mean_square(straight)):
            left = np.concatenate([left, moved(SHARES, steps[b])])
        rest = [mean_square(each) for each in left[:, others]]
        r[rows] = left[int(np.argmin(rest)), rows]
    return r
