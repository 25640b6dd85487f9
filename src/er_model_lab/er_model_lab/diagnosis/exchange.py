"""Effects of several passes exchanged for what came near them: what was found later may have decided otherwise.

Each pass decides beside what those before it have found. A play in series and a compliance gain alike as long as the
viscosity is wrong; once that is right, one of them leaves less.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from operator import itemgetter

from er_models.model import Model

from er_model_lab.diagnosis.candidates import A_LOOK, Candidate, cross_judged, effect_size
from er_model_lab.diagnosis.search import Round, close, taken_in
from er_model_lab.diagnosis.ties import rises
from er_model_lab.fitting.fit import LOOKS, fit
from er_model_lab.problem.problem import Problem

RIVALS = 3
"""Effects that one of a model may be exchanged for, those that came nearest."""
FINALISTS = 2
"""Exchanges that are fitted to the end, those that promise most."""
MOST = 3
"""Exchanges, one after the other."""
EXCHANGING = "exchanging effects"
Exchange = tuple[str, str]
"""The effect that goes, and the one that comes."""
Trial = tuple[Exchange, Model]
"""An exchange, and the model after it."""


def exchanged_late(
    best: Candidate, rounds: Iterable[Round], problem: Problem, limit: float
) -> tuple[Candidate, tuple[Exchange, ...]]:
    """A model after the exchanges that lower its error by more than a limit [N], and these.

    best: with the effects of all passes; rounds: of all passes. Held-out data may refuse an exchange.
    """
    near = _pairs(taken_in(rounds), best.fit.model)
    made: list[Exchange] = []
    while len(made) < MOST:
        settled = {name for pair in made for name in pair}
        held = {*best.fit.model.effects, *settled}
        trials = [
            ((name, other), best.fit.model.without_effect(name).with_effect(other, values))
            for (name, other), values in near.items()
            if name in best.effects and name not in settled and other not in held
        ]
        found = _best_of(best, trials, problem, limit) if trials else None
        if found is None:
            break
        best, pair = found
        made.append(pair)
    return best, tuple(made)


def _pairs(taken: Mapping[str, Round], model: Model) -> dict[Exchange, Mapping[str, float]]:
    """What came near an effect that was taken may come in its place, or in that of one taken later beside it.

    With the values that it had then; taken: the round of each, in their order; model: holds what need not come.
    """
    order, found = list(taken), dict[Exchange, Mapping[str, float]]()
    for k, first in enumerate(order):
        step = taken[first]
        at = {c.name: c.fit.model.effects[c.name] for c in step.candidates}
        for other in [name for name in close(step) if name not in model.effects][:RIVALS]:
            found |= {(name, other): at[other] for name in order[k:]}
    return found


def _best_of(
    best: Candidate, trials: list[Trial], problem: Problem, limit: float
) -> tuple[Candidate, Exchange] | None:
    """The exchange that lowers the error most, of those that promise it on stretches of many runs; None: none does.

    The model as it is ends as the others do before they are compared with it.
    """
    few = problem.practice.problem if problem.practice else problem
    models = [best.fit.model, *(model for _, model in trials)]
    (own, least), *looks = few.each(_looked, models, stage=EXCHANGING)
    seen = [(left, pair, model) for (model, left), (pair, _) in zip(looks, trials, strict=True)]
    ahead = sorted((each for each in seen if each[0] < least), key=itemgetter(0))[:FINALISTS]
    if not ahead:
        return None
    jobs = [(None, own), *((pair, model) for _, pair, model in ahead)]
    as_it_is, *ended = problem.each(_ended, jobs, best, stage=EXCHANGING)
    good = [
        (c, pair)
        for c, (_, pair, _) in zip(ended, ahead, strict=True)
        if effect_size(as_it_is, c) > limit and not rises(best, c, problem)
    ]
    return min(good, key=lambda each: each[0].left, default=None)


def _looked(model: Model, problem: Problem) -> tuple[Model, float]:
    """A model fitted to stretches, and the mean square that it leaves there [N2].

    With another effect in it a fit ends in a valley: one that begins anew where a short one ended goes on.
    """
    begun = fit(model, problem, sketch=True, max_iter=A_LOOK)
    found = fit(begun.model, problem, sketch=True)
    return found.model, found.mse(problem.train)


def _ended(job: tuple[Exchange | None, Model], problem: Problem, best: Candidate) -> Candidate:
    """The model after an exchange, or without one, fitted to all data."""
    pair, model = job
    gone, come = pair or ("", "")
    effects = tuple(come if name == gone else name for name in best.effects)
    return cross_judged(effects, fit(model, problem, max_iter=30, looks=LOOKS), problem)
