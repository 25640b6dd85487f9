"""Refinements that do another effect's work.

A friction that grips harder one way passes for a preload: as long as that is missing, the friction gains by both.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from er_model_lab.diagnosis.candidates import FINALISTS, Candidate, cross_judged, effect_size
from er_model_lab.fitting.fit import FIRST_ITERATIONS, fit, standard_deviations
from er_model_lab.problem.problem import Problem

CERTAIN = 2.0
"""Standard deviations by which a refinement differs from doing nothing where it is in use."""
Place = tuple[str, str]
"""An effect, and one of its parameters."""
Other = tuple[str, Mapping[str, float]]
"""An effect and its values [SI]."""


def stands_in(
    base: Candidate, taken: Candidate, able: Sequence[Candidate], problem: Problem, limit: float
) -> bool:
    """Whether a refinement of what a round takes stands for another effect, of one parameter, that is missing.

    Both have as many parameters then; the other effect in the refinement's place leaves less by more than the limit
    [N]. able: what passes, best first.
    """
    catalogue = base.fit.model.catalogue
    plain = [c for c in able if c is not taken and len(catalogue[c.name].parameters) == 1]
    trades = [(own_values(c), q) for q in refined(taken, problem) for c in plain[:FINALISTS]]
    trials = problem.each(_traded, trades, taken) if trades else []
    return any(effect_size(taken, c) > limit for c in trials)


def refined(candidate: Candidate, problem: Problem) -> list[Place]:
    """Refinements of a candidate's effect that are in use."""
    fitted, model = candidate.fit, candidate.fit.model
    effect, found = model.catalogue[candidate.name], list[Place]()
    if not any(q.optional for q in effect.parameters):
        return found
    for place, sd in zip(fitted.free, standard_deviations(fitted, problem), strict=True):
        if place[0] != effect.name or not effect.parameter(place[1]).optional:
            continue
        away = abs(model.value(*place) - (effect.parameter(place[1]).neutral or 0.0))
        if away > (CERTAIN * sd if np.isfinite(sd) else 0.0):
            found.append(place)
    return found


def own_values(candidate: Candidate) -> Other:
    """A candidate's effect as it was fitted."""
    return candidate.name, candidate.fit.model.effects[candidate.name]


def _traded(trade: tuple[Other, Place], problem: Problem, taken: Candidate) -> Candidate:
    """A candidate with a refinement that does nothing, and another effect beside; refitted."""
    (other, values), (name, refinement) = trade
    model = taken.fit.model
    neutral = model.catalogue[name].parameter(refinement).neutral or 0.0
    idle = model.with_effect(name, {**model.effects[name], refinement: neutral})
    grown = idle.with_effect(other, values)
    free = tuple(f for f in problem.forward.free(grown) if f != (name, refinement))
    found = fit(grown, problem, free, max_iter=FIRST_ITERATIONS)
    return cross_judged((*taken.effects, other), found, problem)
