"""Terms of the model itself begun anew from the catalogue's starting values, where a fit went astray with them."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np
from er_models.effect import Effect
from er_models.model import Model

from er_model_lab.diagnosis.starts import amplitudes, is_gap, play, starts
from er_model_lab.fitting.fit import Fit, fit
from er_model_lab.problem.forward import free_parameters
from er_model_lab.problem.problem import Problem

MOST_RESTARTS = 16
UNMOVED = 1e-4
"""Change of a prediction, over what is left, up to which a parameter does not move it."""
LESS = (1.0, 0.3)
"""Shares of its strength with which an effect goes on whose play another one takes over: alone it did the work of both.
All else of it is as it was, or begins anew."""


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


def handed_over(
    model: Model, effect: Effect, problem: Problem, names: Collection[str] | None = None
) -> list[Model]:
    """The model with one effect more beside another one that has a play; empty where there is none.

    names: of the effects of the model that may be the other one, all by default.

    A friction behind a gap is first met by an effect that has a play of its own. Where all of the damper is behind the
    gap, a fit does not get from the one to the other: the gap takes the play over. Where the gap is there already, the
    friction begins without one of its own.
    """
    if not play(effect):
        return []
    names = model.effects if names is None else names
    if not is_gap(effect):
        return _without_play(model, effect, problem, names)
    gap, first, found = effect.parameters[0].name, starts(effect, problem)[0], list[Model]()
    for name in names:
        held, values = model.catalogue[name], model.effects[name]
        own = play(held)
        if not own:
            continue
        grown = model.with_effect(effect.name, {**first, gap: values[own]})
        strong = {held.names[k]: values[held.names[k]] for k in amplitudes(held)}
        for share in LESS:
            less = {q: share * value for q, value in strong.items()}
            found.append(grown.with_effect(name, {**values, **less, own: 0.0}))
        anew = _once([{**p, **strong, own: 0.0} for p in starts(held, problem)])
        found += [grown.with_effect(name, p) for p in anew]
    return found


def _without_play(
    model: Model, effect: Effect, problem: Problem, names: Collection[str]
) -> list[Model]:
    """The model with an effect more whose own play is none; empty where none of these of its effects is a gap."""
    each = [model.catalogue[n] for n in names]
    if not any(is_gap(e) and play(e) for e in each):
        return []
    points = _once([{**p, play(effect): 0.0} for p in starts(effect, problem)])
    return [model.with_effect(effect.name, p) for p in points]


def _once(points: list[dict[str, float]]) -> list[dict[str, float]]:
    """Starts without those that came before."""
    return [p for k, p in enumerate(points) if p not in points[:k]]


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
