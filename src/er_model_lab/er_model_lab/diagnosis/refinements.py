"""Refinements that do another effect's work.

A friction that grips harder one way passes for a preload: as long as that is missing, the friction gains by both.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from er_models.model import Model

from er_model_lab.diagnosis.candidates import Candidate
from er_model_lab.diagnosis.ranking import FINALISTS
from er_model_lab.fitting.deviations import standard_deviations
from er_model_lab.fitting.fit import FIRST_ITERATIONS, fit, mean_square
from er_model_lab.problem.forward import Free
from er_model_lab.problem.problem import Problem

CERTAIN = 2.0
"""Standard deviations by which a refinement differs from doing nothing where it is in use."""
NOTHING = 1e-6
"""Share of the way between its bounds up to which a value does nothing."""
MORE = 0.8
"""Share of its use without an effect that a refinement has beside it, below which it does that effect's work."""
Place = tuple[str, str]
"""An effect, and one of its parameters."""
Other = tuple[str, Mapping[str, float]]
"""An effect and its values [SI]."""
Trade = tuple[Model, Free]
"""A model with one effect in the place of another's refinement, and what of it is fitted."""


def stands_in(
    base: Candidate, taken: Candidate, able: Sequence[Candidate], problem: Problem, limit: float
) -> bool:
    """Whether a refinement of what a round takes stands for another effect, of one parameter, that is missing.

    Both have as many parameters then, so that the fits alone compare; the other effect in the refinement's place leaves
    less by more than the limit [N]. able: what passes, best first.
    """
    catalogue = base.fit.model.catalogue
    plain = [c for c in able if c is not taken and len(catalogue[c.name].parameters) == 1]
    places = refined(taken, problem) if plain else []
    trades = [_traded(taken, own_values(c), q, problem) for q in places for c in plain[:FINALISTS]]
    return _gains(trades, taken, problem, limit**2, limit)


def makes_up(kept: Candidate, without: Candidate, problem: Problem, limit: float) -> bool:
    """Whether a refinement alone makes up for an effect of one parameter that was taken out of a model.

    It does more than it did beside that effect, and with the effect in its place the model leaves no more, by more than
    the limit [N].
    """
    model = kept.fit.model
    (gone,) = {*kept.effects} - {*without.effects}
    if len(model.catalogue[gone].parameters) > 1:
        return False
    used = refined(without, problem, without.fit.model.effects)
    places = [q for q in used if _use(kept, q) < MORE * _use(without, q)]
    trades = [_traded(without, (gone, model.effects[gone]), q, problem) for q in places]
    return _gains(trades, without, problem, -(limit**2), limit)


def refined(
    candidate: Candidate, problem: Problem, names: Collection[str] | None = None
) -> list[Place]:
    """Refinements that are in use, of some effects of a candidate, or of the one that was added last."""
    fitted, model = candidate.fit, candidate.fit.model
    names, found = names or [candidate.name], list[Place]()
    form = [e in names and model.catalogue[e].parameter(q).optional for e, q in fitted.free]
    if not any(form):
        return found
    deviations = standard_deviations(fitted, problem)
    for place, own, sd in zip(fitted.free, form, deviations, strict=True):
        low, high = model.bounds(*place)
        least = CERTAIN * sd if np.isfinite(sd) else NOTHING * (high - low)
        if own and _use(candidate, place) > least:
            found.append(place)
    return found


def _use(candidate: Candidate, place: Place) -> float:
    """How far a refinement of a candidate is from doing nothing."""
    model = candidate.fit.model
    return abs(model.value(*place) - _neutral(model, place))


def _neutral(model: Model, place: Place) -> float:
    """The value of a refinement that does nothing."""
    return model.catalogue[place[0]].parameter(place[1]).neutral or 0.0


def own_values(candidate: Candidate) -> Other:
    """A candidate's effect as it was fitted."""
    return candidate.name, candidate.fit.model.effects[candidate.name]


def _traded(taken: Candidate, other: Other, place: Place, problem: Problem) -> Trade:
    """The model of a candidate with a refinement that does nothing, and another effect beside; what of it is fitted."""
    (name, refinement), model = place, taken.fit.model
    idle = {**model.effects[name], refinement: _neutral(model, place)}
    grown = model.with_effect(name, idle).with_effect(*other)
    return grown, tuple(f for f in problem.forward.free(grown) if f != place)


def _gains(
    trades: list[Trade], beside: Candidate, problem: Problem, least: float, limit: float
) -> bool:
    """Whether a trade leaves less than a candidate, by more than a mean square [N2], which may be negative.

    Of many runs stretches rule out what falls short there, too, by more than the limit [N]; a fit to them alone leaves
    less of them than one to all.
    """
    few = problem.practice
    if few and trades:
        here = mean_square(beside.fit.residual[few.rows][few.problem.train])
        begun = few.problem.each(_left_by, trades)
        trades = [trade for trade, mse in begun if here - mse > least - limit**2]
    left = problem.each(_left_by, trades) if trades else []
    return any(beside.seen - mse > least for _, mse in left)


def _left_by(trade: Trade, problem: Problem) -> tuple[Trade, float]:
    """A trade, fitted, and the mean square that it leaves [N2]."""
    model, free = trade
    found = fit(model, problem, free, max_iter=FIRST_ITERATIONS, sketch=True)
    return (found.model, free), found.mse(problem.train)
