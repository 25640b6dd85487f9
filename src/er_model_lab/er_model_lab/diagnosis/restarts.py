"""Terms of the model itself begun anew from the catalogue's starting values, where a fit went astray with them."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from er_models.model import Model

from er_model_lab.diagnosis.starts import starts
from er_model_lab.fitting.fit import Fit, fit
from er_model_lab.problem.forward import free_parameters
from er_model_lab.problem.problem import Problem

MOST_RESTARTS = 16
UNMOVED = 1e-4
"""Change of a prediction, over what is left, up to which a parameter does not move it."""


def terms(model: Model) -> list[str]:
    """Terms of a model that are fitted."""
    return list(dict.fromkeys(effect for effect, _ in free_parameters(model)))


def restarts(model: Model, problem: Problem, names: Sequence[str]) -> list[Model]:
    """The model with the starting values of some of its terms, scaled to the data."""
    grids = {name: starts(model.catalogue[name], problem) for name in names}
    combinations = itertools.islice(itertools.product(*grids.values()), MOST_RESTARTS)
    return [
        replace(model, effects={**model.effects, **dict(zip(grids, values, strict=True))})
        for values in combinations
    ]


def awakened(fitted: Fit, problem: Problem, look: int, max_iter: int) -> Fit:
    """The fit, or a better one where terms of the model's core were asleep, begun anew.

    A model that lacks an effect bends its own terms towards it. Once the effect is there these fall to nothing, and an
    amplitude of zero says of no other parameter where it should go. look: iterations that each start gets, on stretches
    of many runs; max_iter: of the best one, on all.
    """
    few = problem.practice
    where = few.problem if few else problem
    begun = [
        fit(model, where, max_iter=look, sketch=bool(few))
        for name in _asleep(fitted)
        for model in restarts(fitted.model, problem, [name])
    ]
    if not begun:
        return fitted
    best = min(begun, key=lambda f: f.mse(where.train))
    again = fit(best.model, problem, max_iter=max_iter)
    return min((fitted, again), key=lambda f: f.mse(problem.train))


def _asleep(fitted: Fit) -> list[str]:
    """Terms of the model's core on whose parameters, all but one, the prediction next to does not depend."""
    moving: dict[str, list[bool]] = {}
    least = UNMOVED * np.linalg.norm(fitted.residual)
    for (name, _), column in zip(fitted.free, fitted.jacobian.T, strict=True):
        if fitted.model.catalogue[name].stage == "core":
            moving.setdefault(name, []).append(bool(np.linalg.norm(column) > least))
    return [name for name, some in moving.items() if len(some) > 1 and sum(some) <= 1]
