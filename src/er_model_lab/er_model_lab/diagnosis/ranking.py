"""Every missing effect beside a model: each gets a look, and those that may win are fitted to the end."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from er_models.effect import SMOOTH, Effect
from er_models.model import Array
from numpy.typing import NDArray

from er_model_lab.diagnosis.candidates import (
    A_LOOK,
    STARTS,
    Candidate,
    Screen,
    Values,
    cross_judged,
    effect_size,
    for_a_choice,
    gone_on_here,
    missing,
    on_all,
    on_part,
    predicted,
    sketched,
)
from er_model_lab.diagnosis.starts import is_gap
from er_model_lab.fitting.fit import FIRST_ITERATIONS, Fit, about, fit
from er_model_lab.problem.forward import ROUGH
from er_model_lab.problem.problem import Practice, Problem
from er_model_lab.work import Leader

Look = tuple[str, Sequence[Values]]
"""An effect to be looked at, and values that it had beside a smaller model."""
FINALISTS = 4
"""Candidates that are fitted to the end; of many runs these are fitted to all."""
TRYING, FINISHING = "trying effects", "fitting the best to the end"
"""Stages of a round that take long."""
MAY_WIN = 0.25
"""Share of the best one's gain from which on a fit is brought to its end, as mean squares: a tie asks for far more."""


@dataclass(frozen=True)
class Begun:
    """An effect that was begun to be fitted to stretches, and what a straight line said of it."""

    name: str
    fit: Fit
    seen: Screen


def refit_all(
    base: Candidate, problem: Problem, effects: Iterable[Effect] | None = None, before: Iterable[Candidate] = ()
) -> list[Candidate]:  # fmt: skip
    """Every missing effect refitted, best held-out error first; the best few are fitted to the end.

    before: what was tried beside the model before it grew; effects are begun from these values, and from one start
    more.
    """
    able = missing(base.fit.model, problem) if effects is None else effects
    known = {c.name: [c.fit.model.effects[c.name]] for c in before}
    looks: list[Look] = [(e.name, known.get(e.name, ())) for e in sorted(able, key=_quick)]
    few = problem.practice
    return _refit_many(base, problem, few, looks) if few else _refit_here(base, problem, looks)


def _quick(effect: Effect) -> bool:
    """Whether an effect is fitted soon; one whose events make that long is begun first, so that nobody waits for it."""
    return all(q.step == SMOOTH for q in effect.parameters)


def _refit_many(
    base: Candidate, problem: Problem, few: Practice, effects: list[Look]
) -> list[Candidate]:
    """Of many runs: every effect fitted to stretches, the best few to all; the others are judged as they are there."""
    known = base.fit.jacobian
    base = replace(base, fit=replace(base.fit, columns=(known,)))
    part, rows = on_part(base, few), few.problem.train
    near = about(part.fit, few.problem.begun(part.fit.model), ROUGH)
    looked = _by_gain(near.each(_begun, effects, part, STARTS, stage=TRYING), part, rows)
    begun = _by_gain(near.each(_gone_on, looked, stage=TRYING), part, rows)
    jobs = [(b, able and place < FINALISTS) for place, (b, able) in enumerate(begun)]
    near, best = about(base.fit, problem, ROUGH), partial(leaders, base)
    judged = near.each(_judged, jobs, base, near.begun(base.fit.model), stage=FINISHING, best=best)
    found = predicted([_beside(c, known) for c in judged])
    found.sort(key=lambda c: c.left)
    return _ended(base, found, problem)


def _refit_here(base: Candidate, problem: Problem, effects: list[Look]) -> list[Candidate]:
    """Every effect for a look, those that may win to their end; the others are judged where the look has led."""
    rows, near = problem.train, about(base.fit, problem.begun(base.fit.model))
    seen = partial(_seen, base, rows)
    looked = _by_gain(near.each(_begun, effects, base, 1, stage=TRYING, best=seen), base, rows)
    best = partial(leaders, base)
    found = predicted(problem.each(_gone_to_its_end, looked, base, stage=FINISHING, best=best))
    found.sort(key=lambda c: c.mse)
    return _ended(base, found, problem)


def _seen(base: Candidate, rows: NDArray[np.bool_], begun: list[Begun]) -> list[Leader]:
    """The best of what was looked at so far, best first: by the error of the fit, without cross-validation."""
    ahead = _by_gain(begun, base, rows)[:FINALISTS]
    left = [b.fit.mse(rows) for b, _ in ahead]
    gains = [float(np.sqrt(max(base.fit.mse(rows) - mse, 0.0))) for mse in left]
    return [
        Leader(b.name, float(np.sqrt(mse)), gain)
        for (b, _), mse, gain in zip(ahead, left, gains, strict=True)
    ]


def _gone_to_its_end(job: tuple[Begun, bool], problem: Problem, base: Candidate) -> Candidate:
    """An effect fitted on from a look where it may win, which the job says; from the best of several starts then."""
    begun, able = job
    names, seen, looked = (*base.effects, begun.name), begun.seen, begun.fit
    if able:
        near, known = about(base.fit, problem), base.fit.jacobian
        others = (base.fit.model.with_effect(begun.name, v) for v in seen.points[1:STARTS])
        looks = [fit(m, near, known=known, max_iter=A_LOOK, sketch=True) for m in others]
        looked = min([looked, *looks], key=lambda f: f.mse(problem.train))
    fitted = gone_on_here(base, looked, seen, problem, FIRST_ITERATIONS if able else 0)
    found = cross_judged(names, fitted, problem, seen.kept, seen.reach, straight=not able)
    return replace(found, ranked=not able)


def _by_gain(
    begun: list[Begun], base: Candidate, rows: NDArray[np.bool_]
) -> list[tuple[Begun, bool]]:
    """Effects begun beside a model, the one that gains most first, each with whether it may win."""
    begun = sorted(begun, key=lambda b: b.fit.mse(rows))
    gains = [base.fit.mse(rows) - b.fit.mse(rows) for b in begun]
    return [(b, may_win(gain, gains[0])) for b, gain in zip(begun, gains, strict=True)]


def may_win(gain: float, best: float) -> bool:
    """Whether a gain that is not the whole one yet may become the best."""
    return gain >= MAY_WIN * best


def _ended(base: Candidate, found: list[Candidate], problem: Problem) -> list[Candidate]:
    """Candidates, best first, with those of the best few that may still win fitted to the end.

    Where a gap lies tells only a closer look.
    """
    gains = [base.mse - c.mse for c in found]
    ahead = [
        c
        for c, gain in zip(found[:FINALISTS], gains, strict=False)
        if may_win(gain, gains[0]) or is_gap(c.fit.model.catalogue[c.name])
    ]
    ended = problem.each(for_a_choice, range(len(ahead)), ahead, stage=FINISHING)
    return sorted(
        [*ended, *(c for c in found if not any(c is a for a in ahead))], key=lambda c: c.mse
    )


def _begun(job: Look, problem: Problem, base: Candidate, usual: int) -> Begun:
    """An effect, with values that it had before, fitted for a look; problem and base: of the stretches, if any."""
    name, also = job
    effect = base.fit.model.catalogue[name]
    seen = sketched(base, effect, problem, A_LOOK, usual, also)
    return Begun(name, *seen)


def _gone_on(job: tuple[Begun, bool], problem: Problem) -> Begun:
    """An effect fitted on to stretches where a look had used its iterations up and it may win, which the job says."""
    begun, able = job
    if not able or begun.fit.iterations < A_LOOK:
        return begun
    longer = fit(begun.fit.model, problem, max_iter=FIRST_ITERATIONS - A_LOOK, sketch=True)
    return replace(begun, fit=longer)


def _judged(
    job: tuple[Begun, bool], problem: Problem, base: Candidate, where_base_begins: Problem
) -> Candidate:
    """A fit to stretches, fitted to all runs where it is one of the best, which the job says.

    Derivatives that the base has stay there: those of all candidates would be most of the memory. where_base_begins:
    the same problem, `begun` at the base, which is enough for the others.
    """
    begun, ahead = job
    problem = problem if ahead else where_base_begins
    fitted = on_all(base, begun.fit, problem, FIRST_ITERATIONS if ahead else 0)
    names, seen = (*base.effects, begun.name), begun.seen
    found = cross_judged(names, fitted, problem, seen.kept, seen.reach, straight=not ahead)
    columns = fitted.columns
    own = columns[1:] if columns[0] is base.fit.columns[0] else columns
    return replace(found, ranked=True, fit=replace(fitted, columns=own))


def _beside(candidate: Candidate, known: Array) -> Candidate:
    """A candidate with the derivatives (n, k) that stayed at its base, where it has none of its own of them."""
    columns = candidate.fit.columns
    if sum(part.shape[1] for part in columns) == candidate.fit.theta.size:
        return candidate
    return replace(candidate, fit=replace(candidate.fit, columns=(known, *columns)))


def leaders(base: Candidate, found: list[Candidate]) -> list[Leader]:
    """The best of what was tried so far, best first."""
    ahead = sorted(found, key=lambda c: c.mse)[:FINALISTS]
    return [Leader(c.name, float(np.sqrt(c.mse)), effect_size(base, c)) for c in ahead]
