"""Forms and their special cases: which of the two stands for both, and where they are tied.

A joint whose gap does nothing is a mount that gives way; Stribeck friction without breakaway is Coulomb friction.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from er_models.model import Model

from er_model_lab.diagnosis.candidates import Candidate, cross_judged, effect_size, finished
from er_model_lab.diagnosis.passing import FAR_BEYOND
from er_model_lab.diagnosis.rule import Rule
from er_model_lab.diagnosis.search import Round
from er_model_lab.diagnosis.ties import SAME, rises
from er_model_lab.fitting.fit import fit, mean_square, practised
from er_model_lab.problem.problem import Problem

OWN = 0.05
"""Share of what a generalised form changes up to which what its special case has not is next to nothing."""


def as_one(
    best: Candidate, rounds: list[Round], problem: Problem, rule: Rule
) -> tuple[Candidate, tuple[str, ...]]:
    """A model with a generalised form for its special case and all that was added later, and that form's name.

    It leaves no more than those; `rounds` ends with it then.

    It was left out where it gained not far more than its special case. A further effect says that this was not all.
    """
    for i, step in enumerate(rounds):
        taken = step.taken
        if taken is None or taken.name not in best.effects or best.effects == taken.effects:
            continue
        catalogue = taken.fit.model.catalogue
        forms = [
            c
            for c in step.candidates
            if taken.name in catalogue[c.name].generalises and c.name not in rule.barred
        ]
        for form in (c for c in forms if len(c.effects) < len(best.effects)):
            ended = finished(form, problem) if form.ranked else form
            if ended.seen <= best.seen:
                rounds[i:] = [replace(step, taken=ended, ties=[ended.name])]
                return ended, (ended.name,)
    return best, ()


def plain(
    best: Candidate, problem: Problem, limit: float, earned: tuple[str, ...] = ()
) -> tuple[Candidate, tuple[tuple[str, ...], ...]]:
    """A fitted model with special cases in place of generalised forms that do not gain far more, and ties with them.

    earned: forms that stand for more than their special case; so does one beside which held-out data refuse that.

    A form that needs next to nothing beyond what its special case has, though that by itself fits worse, is tied with
    it: a joint that gives way and whose gap is a thousandth of the stroke is a mount that friction stretches. A simple
    effect that a richer one holds stands in its place where it leaves the same; beside other effects also where
    it is behind by nothing that counts: the richer one may have done their work before they were there.
    """
    catalogue, ties = best.fit.model.catalogue, []
    for name in best.effects:
        held = [specialised(best, name, other, problem) for other in _held_in(best, name, problem)]
        if held:
            trial = min(held, key=lambda c: c.mse)
            alike = trial.seen <= (1.0 + SAME) * best.seen
            if alike or (len(best.effects) > 1 and effect_size(trial, best) <= limit):
                best = trial
        for special in catalogue[name].generalises:
            model = best.fit.model
            if special in model.effects or name not in model.effects:
                continue
            trial = specialised(best, name, special, problem)
            more = name in earned or effect_size(trial, best) > FAR_BEYOND * limit
            if not more and not rises(best, trial, problem):
                best = trial
                continue
            own = left_as(best, name, special, problem) - best.seen
            if own <= limit**2 or own <= (OWN * size_of(name, best, problem)) ** 2:
                ties.append((name, special))
    return best, tuple(ties)


def _held_in(best: Candidate, name: str, problem: Problem) -> list[str]:
    """Rivals of fewer parameters that an effect of a model is, once all else of it does nothing.

    Stribeck friction without breakaway is Coulomb friction.
    """
    model, found = best.fit.model, list[str]()
    for other in model.catalogue[name].signature.rivals if name in model.effects else ():
        shared = _plain_names(model, other)
        if other in model.effects or not shared < {*model.effects[name]}:
            continue
        simple, less = (make(model, name, other) for make in (as_special, idle_but))
        change = problem.predict(simple) - problem.predict(less)
        if mean_square(change[problem.train]) < SAME * best.seen:
            found.append(other)
    return found


def _plain_names(model: Model, effect: str) -> set[str]:
    """Parameters of an effect, refinements left out."""
    return {q.name for q in model.catalogue[effect].parameters if not q.optional}


def specialised(best: Candidate, name: str, special: str, problem: Problem) -> Candidate:
    """A fitted model with a special case in the place of a generalised form, refitted.

    It begins with the values that both share: from a start of its own it may have ended elsewhere.
    """
    simple = as_special(best.fit.model, name, special)
    effects = tuple(special if e == name else e for e in best.effects)
    return cross_judged(effects, fit(practised(simple, problem), problem), problem)


def left_as(best: Candidate, name: str, special: str, problem: Problem) -> float:
    """Mean square [N2] that a fitted model leaves with a form as its special case is: what else it has does nothing.

    Infinite where the form does not hold all values of the special case: without the others it is nothing.
    """
    model, effect = best.fit.model, best.fit.model.catalogue[name]
    if not _plain_names(model, special) <= {*effect.names}:
        return np.inf
    return fit(idle_but(model, name, special), problem, max_iter=0).mse(problem.train)


def size_of(name: str, candidate: Candidate, problem: Problem) -> float:
    """What an effect of a fitted model changes of the force, root mean square [N]."""
    model = candidate.fit.model
    change = problem.predict(model) - problem.predict(model.without_effect(name))
    return float(np.sqrt(mean_square(change[problem.train])))


def as_special(model: Model, name: str, special: str) -> Model:
    """The model with a special case in the place of a form, with the values that both share."""
    shared = model.catalogue[special].names
    values = {q: value for q, value in model.effects[name].items() if q in shared}
    return model.without_effect(name).with_effect(special, values)


def idle_but(model: Model, name: str, special: str) -> Model:
    """The model with a form of which nothing acts but what its special case has."""
    shared = model.catalogue[special].names
    idle = {
        q.name: q.neutral
        for q in model.catalogue[name].parameters
        if q.name not in shared and q.neutral is not None
    }
    return model.with_effect(name, {**model.effects[name], **idle})
