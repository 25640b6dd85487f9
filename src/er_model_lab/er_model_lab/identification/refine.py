"""The joint refinement: all parameters together on all samples; what the data do not say is held."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from er_models.model import Model

from er_model_lab.fitting.fit import Box, Fit, fit
from er_model_lab.identification.stages import taken_over
from er_model_lab.identification.visibility import Visibility, imitators, visibility
from er_model_lab.problem.forward import Free, free_parameters
from er_model_lab.problem.problem import Problem

MOST_ITERATIONS = 60
TOLERANCE = 1e-7
POOR = 1.3
"""Residual over the white noise of the force from which another start is tried."""


@dataclass(frozen=True)
class Refined:
    """The refined fit, what the data say of its parameters, and what was held at the given model's value.

    taken_up: for each held parameter, those that take up its change: their values hold for that value only.
    """

    fit: Fit
    visibility: Visibility
    held: Free
    taken_up: Mapping[tuple[str, str], Free]


def refine(start: Model, given: Model, problem: Problem) -> Refined:
    """Fit all parameters, then hold, one by one, what the data do not say.

    From the values of the stages; where they leave far more than noise, from the given model's as well.
    """
    best = fit(start, problem, max_iter=MOST_ITERATIONS, tol=TOLERANCE)
    if np.sqrt(best.mse(problem.train)) > POOR * problem.sd_force:
        other = fit(given, problem, max_iter=MOST_ITERATIONS, tol=TOLERANCE)
        best = min(best, other, key=lambda f: f.mse(problem.train))
    free = free_parameters(given)
    held: Free = ()
    taken_up: dict[tuple[str, str], Free] = {}
    seen = visibility(best, problem)
    while np.any(seen.unknown) and free:
        out = _least_known(best, seen, problem)
        held = (*held, *out)
        taken_up |= {q: imitators(best, problem, best.free.index(q)) for q in out}
        free = tuple(q for q in free if q not in out)
        kept = taken_over(best.model, _inside(given, out, problem), out)
        best = fit(kept, problem, free, max_iter=MOST_ITERATIONS, tol=TOLERANCE)
        seen = visibility(best, problem)
    fitted = {q: tuple(o for o in others if o in best.free) for q, others in taken_up.items()}
    return Refined(best, seen, held, fitted)


def _least_known(fitted: Fit, seen: Visibility, problem: Problem) -> Free:
    """What to hold next: all that the force does not feel, else the least known, shapes before amplitudes."""
    felt = np.any(fitted.jacobian[problem.train] != 0.0, axis=0)
    if not np.all(felt):
        return tuple(q for q, some in zip(fitted.free, felt, strict=True) if not some)
    neutral = [fitted.model.catalogue[e].parameter(name).neutral for e, name in fitted.free]
    order = [
        (unknown, value is None, size)
        for unknown, value, size in zip(seen.unknown, neutral, seen.relative, strict=True)
    ]
    return (fitted.free[order.index(max(order))],)


def _inside(given: Model, held: Free, problem: Problem) -> Model:
    """The given model with the held values moved into the bounds the data set."""
    box = Box(given, held, problem.scales)
    return box.model_at(box.start())
