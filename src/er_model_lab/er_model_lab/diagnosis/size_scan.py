"""Gaps and limits, whose fits have many narrow valleys: their sizes are looked over before they are fitted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from er_models.effect import Effect
from er_models.model import Array, Model

from er_model_lab.fitting.fit import FIRST_ITERATIONS, Fit, about, fit
from er_model_lab.problem.problem import Problem

SCANNED, SCANS, WORTHWHILE = 25, 3, 0.01
"""Values of a limit of the car that are looked at, how often, and the gain that is worth another look."""
ABOUT = np.geomspace(0.6, 1.6, 7)
"""Sizes about a fitted gap, as shares of it, that are looked at."""


def profiled(fitted: Fit, name: str, problem: Problem) -> Fit:
    """A model fitted with a gap, from the best of sizes about it while all else follows in a straight line.

    Ever closer to it: derivatives by the gap say little beyond the nearest contact.
    """
    q, train, best = fitted.model.catalogue[name].parameters[0].name, problem.train, fitted
    place = fitted.free.index((name, q))
    near = about(fitted, problem)
    for closer in range(SCANS):
        values = best.model.effects[name]
        sizes = values[q] * ABOUT ** (2.0**-closer)
        grown, left = _left_over(best.model, name, [{**values, q: float(s)} for s in sizes], near)
        left = left.T
        j = np.delete(best.jacobian[train], place, axis=1)
        left = np.nan_to_num(left) - j @ np.linalg.lstsq(j, np.nan_to_num(left), rcond=1e-10)[0]
        costs = np.mean(left**2, axis=0)
        if costs.min() < (1.0 - WORTHWHILE) * best.mse(train):
            tried = fit(grown[int(np.argmin(costs))], problem, max_iter=FIRST_ITERATIONS)
            best = tried if tried.mse(train) < best.mse(train) else best
    return best


def scanned(fitted: Fit, effect: Effect, problem: Problem) -> Fit:
    """A model fitted with a limit, each time from the best of many values of it, as long as that helps.

    A limit has one narrow valley, for what it cuts off at one peak decides where the next ones are; and where the
    valley lies depends on what was fitted without it.
    """
    (q,) = effect.parameters
    values = problem.scales.of(q.unit) * np.geomspace(min(q.starts), max(q.starts), SCANNED)
    model, best, near = fitted.model, fitted, about(fitted, problem)
    for _ in range(SCANS):
        grown, left = _left_over(model, effect.name, [{q.name: float(v)} for v in values], near)
        cost = np.nan_to_num(np.mean(left**2, axis=1), nan=np.inf)
        tried = fit(grown[int(np.argmin(cost))], problem, max_iter=FIRST_ITERATIONS)
        if not tried.mse(problem.train) < (1.0 - WORTHWHILE) * best.mse(problem.train):
            break
        model, best = tried.model, tried
    return best


def _left_over(
    model: Model, name: str, values: Sequence[Mapping[str, float]], problem: Problem
) -> tuple[list[Model], Array]:
    """The model with each of the values (k) of an effect, and what it leaves of the force where it is fitted (k, m)."""
    grown = [model.with_effect(name, each) for each in values]
    vectors = np.stack([m.compiled().p for m in grown])
    return grown, (problem.force - problem.predict_many(grown[0], vectors))[:, problem.train]
