"""Which effects to add: forward one at a time, pairs where one is not enough, backward, and ties."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from er_model_lab.diagnosis.candidates import (
    HOPE,
    Candidate,
    chosen_among,
    effect_size,
    finished,
    for_a_choice,
    left_without,
    refit,
    roughly_without,
    screen,
    to_the_end,
)
from er_model_lab.diagnosis.determined import loose, strange
from er_model_lab.diagnosis.null import Null, simulate_null
from er_model_lab.diagnosis.passing import (
    FAR_BEYOND,
    beyond_motion,
    passes,
    there,
    threshold,
)
from er_model_lab.diagnosis.ranking import refit_all
from er_model_lab.diagnosis.refinements import makes_up, stands_in
from er_model_lab.diagnosis.rule import RULE, Rule
from er_model_lab.diagnosis.ties import NEARLY, rises, rivals, tied
from er_model_lab.problem.problem import Problem

PAIRS_OF = 6
"""Pairs are tried among this many best singles."""
WEAKEST = 2
"""Effects that are left out on all of many runs, those that stretches need least."""
PLAINLY = 2.0
"""Size, over what counts, from which on an effect is needed by a fit in longer steps alone."""
LEAVING_OUT = "leaving effects out"
MOST_EFFECTS = 3
PROMISE = 1.5
"""Size, over what chance gives, from which a candidate left over is worth another round."""


@dataclass(frozen=True)
class Round:
    """One step of the search: where it began, every candidate, the null, and what was taken."""

    base: Candidate
    candidates: list[Candidate]
    null: Null
    threshold: float
    taken: Candidate | None
    ties: list[str]


def afresh(step: Round) -> Round:
    """A round as the first of a search that begins with its model: of effects only the one that it tried is named."""
    many = len(step.base.effects)
    tried = [replace(c, effects=c.effects[many:]) for c in step.candidates]
    taken = next((n for c, n in zip(step.candidates, tried, strict=True) if c is step.taken), None)
    return replace(step, base=replace(step.base, effects=()), candidates=tried, taken=taken)


def one_round(
    base: Candidate, problem: Problem, seed: int, rule: Rule = RULE, last: Round | None = None
) -> Round:
    """Refit every missing effect, calibrate, and choose the best or nothing; last: the round before."""
    candidates = refit_all(base, problem, before=last.candidates if last else ())
    null = simulate_null(base, candidates, problem, seed)
    return decided(base, candidates, null, problem, rule)


def decided(
    base: Candidate, candidates: list[Candidate], null: Null, problem: Problem, rule: Rule
) -> Round:
    """The round with the best of its candidates taken, or nothing.

    One that was only ranked is fitted to its end before it is taken. A generalised form is fitted as far as the choice
    needs before it is left out: its special case ends sooner.
    """
    left = np.sqrt(min(candidates[0].mse, base.mse))
    limit = threshold(null, left, rule)
    free = [c for c in candidates if c.name not in rule.barred]
    able = [c for c in free if there(base, c, problem, limit, rule)]
    if rule.small_steps and not able and null.least and not problem.cycles:
        bare = replace(null, least=0.0)
        of_noise = threshold(bare, left, rule)
        able = [
            c
            for c in free
            if there(base, c, problem, of_noise, rule)
            and beyond_motion(base, c, null, problem) > of_noise
        ]
        if able:
            null, limit = bare, of_noise
    refined = [c for c in able if not far_better(base, c, able, limit)]
    closer = problem.each(for_a_choice, range(len(refined)), refined) if refined else []
    ended = {c.name: c for c in closer}
    candidates, able = (
        sorted((ended.get(c.name, c) for c in some), key=lambda c: c.left)
        for some in (candidates, able)
    )
    able = _without_refinements(base, able, limit)
    able = [c for c in able if not strange(c)] or able
    if not able:
        return Round(base, candidates, null, limit, None, [])
    group = tied(base, able, problem, limit)
    taken = group[0]
    if taken.ranked:
        candidates = [finished(c, problem) if c is taken else c for c in candidates]
        return decided(base, sorted(candidates, key=lambda c: c.left), null, problem, rule)
    if rule.small_steps and taken.name in loose(taken, problem):
        return decided(base, candidates, null, problem, _without(taken, rule))
    if stands_in(base, taken, able, problem, limit):
        return decided(base, candidates, null, problem, _without(taken, rule))
    ties = [c.name for c in group if c is taken or rivals(taken, c, problem)]
    return Round(base, candidates, null, limit, taken, ties)


def _without(candidate: Candidate, rule: Rule) -> Rule:
    """The rule by which a candidate's effect is not taken."""
    return replace(rule, barred=rule.barred | {candidate.name})


def promising(best: Candidate, step: Round, problem: Problem) -> bool:
    """Whether another candidate of a round gains beside what was taken there, in a straight line.

    Regressions do not see everything: a gap that is crossed within a sample is lost in their noise.
    """
    limit = PROMISE * step.threshold
    others = [
        c for c in step.candidates if c is not step.taken and effect_size(step.base, c) > limit
    ]
    gains = problem.each(_gain_beside, [c.name for c in others], best)
    return any(gain > limit for gain in gains)


def _gain_beside(name: str, problem: Problem, best: Candidate) -> float:
    """What an effect gains beside a model, in a straight line [N]."""
    return screen(best, best.fit.model.catalogue[name], problem).gain


def _without_refinements(base: Candidate, able: list[Candidate], limit: float) -> list[Candidate]:
    """Leave out a generalised form unless it is better than its special cases far beyond the limit."""
    return [c for c in able if far_better(base, c, able, limit)]


def far_better(base: Candidate, form: Candidate, able: list[Candidate], limit: float) -> bool:
    """Whether a form is better, far beyond the limit, than all of some candidates that it generalises."""
    names = base.fit.model.catalogue[form.name].generalises
    return all(effect_size(c, form) > FAR_BEYOND * limit for c in able if c.name in names)


def try_pairs(step: Round, problem: Problem, target: float) -> Candidate | None:
    """Best pair among the best singles, when it reaches the target mean square and beats the best single."""
    names = partners(step)
    singles = {c.name: c for c in step.candidates if c.name in names}
    pairs = problem.each(
        _paired_with, list(itertools.combinations(names, 2)), singles, target, stage="trying pairs"
    )
    best = min(pairs, key=lambda c: c.left, default=None)
    top = step.taken or step.candidates[0]

    def enough(pair: Candidate) -> bool:
        return pair.mse <= target and effect_size(top, pair) >= step.threshold

    if best is None or not enough(best):
        return None
    best = finished(best, problem) if best.ranked else best
    return best if enough(best) else None


def _paired_with(
    two: tuple[str, str], problem: Problem, singles: dict[str, Candidate], target: float
) -> Candidate:
    """A single with a second effect, which shall leave no more than a mean square [N2]."""
    first, second = two
    base = singles[first]
    return refit(base, base.fit.model.catalogue[second], problem, target=target)


def swapped(
    best: Candidate, rounds: list[Round], problem: Problem
) -> tuple[Candidate, tuple[tuple[str, ...], ...]]:
    """The best model once every effect was exchanged for its rivals, and the groups still tied then.

    A tie of the first round is one beside all that was still missing, and so is a lead there (`close`); what
    counts is the tie in the whole model. What came as one of a pair is exchanged for what pairs were tried of.
    """
    groups = []
    for name, step in [*taken_in(rounds).items(), *_paired(best, rounds)]:
        if name not in best.effects:
            continue
        others = [n for n in _near(name, step, best) if n not in best.effects]
        if not others:
            continue
        place, rest = best.effects.index(name), roughly_without(name, problem, best)
        target = best.left + (FAR_BEYOND * step.threshold) ** 2
        again, *trials = problem.each(
            exchanged, [name, *others], rest, place, target, stage="exchanging effects"
        )
        # what others gain by another way there is no merit of theirs
        best = min(best, again, key=lambda c: c.left)
        trials = [c for c in trials if not rises(best, c, problem)]
        able = [_with_last(c, place) for c in sorted([best, *trials], key=lambda c: c.left)]
        alike = tied(rest, able, problem, step.threshold)
        alike[0] = finished(alike[0], problem) if alike[0].ranked else alike[0]
        groups.append(
            tuple(c.name for c in alike if c is alike[0] or rivals(alike[0], c, problem))
        )
        best = _back_at(alike[0], place)
    return best, tuple(g for g in groups if len(g) > 1)


def _with_last(candidate: Candidate, place: int) -> Candidate:
    """A candidate that tells of the effect at a place as if it had been added last: that one is weighed."""
    own, rest = candidate.effects[place], list(candidate.effects)
    del rest[place]
    return replace(candidate, effects=(*rest, own))


def _back_at(candidate: Candidate, place: int) -> Candidate:
    """The same with the last effect at its place."""
    *rest, own = candidate.effects
    return replace(candidate, effects=(*rest[:place], own, *rest[place:]))


def taken_in(rounds: Iterable[Round]) -> dict[str, Round]:
    """Effects that were taken, each with its round: the last one, where it was taken out and taken again."""
    return {step.taken.name: step for step in rounds if step.taken is not None}


def _paired(best: Candidate, rounds: list[Round]) -> list[tuple[str, Round]]:
    """Effects of a model that no round took: those of a pair, with the round whose singles the pairs are of."""
    alone = taken_in(rounds)
    return [(name, rounds[0]) for name in best.effects if name not in alone]


def _near(name: str, step: Round, best: Candidate) -> list[str]:
    """Effects that an effect of a model may be exchanged for."""
    if step.taken is None or step.taken.name != name:
        return partners(step)
    near = step.ties if len(best.effects) < 2 else [*step.ties, *close(step)]
    return list(dict.fromkeys(near))


def partners(step: Round) -> list[str]:
    """The best singles of a round, of which pairs are tried."""
    return [c.name for c in step.candidates if effect_size(step.base, c) > 0][:PAIRS_OF]


def close(step: Round) -> list[str]:
    """Effects that came near the one that a round took: what was missing beside them may have decided."""
    assert step.taken is not None
    least = NEARLY * effect_size(step.base, step.taken)
    able = [c for c in step.candidates if passes(step.base, c, step.threshold)]
    near = _without_refinements(step.base, able, step.threshold)
    return [c.name for c in near if effect_size(step.base, c) >= least]


def exchanged(
    name: str, problem: Problem, rest: Candidate, place: int, target: float = np.inf
) -> Candidate:
    """A model with another effect in the place of the one that was taken out.

    target: mean square [N2] that a sketch must promise to be fitted to the end; else it is judged where that has led.
    """
    effect = rest.fit.model.catalogue[name]
    found = refit(rest, effect, problem, max_iter=20, target=target)
    if found.left <= HOPE * target:
        found = chosen_among(found, problem)
    return replace(found, effects=(*rest.effects[:place], name, *rest.effects[place:]))


def prune(candidate: Candidate, problem: Problem, limit: float) -> Candidate:
    """Take out every added effect that is no longer needed, weakest first.

    One for which a refinement alone makes up stays. Of many runs stretches say which ones are worth a look on all.
    """
    current, few = candidate, problem.practice
    while len(current.effects) > 1:
        names = list(current.effects)
        if few:
            left = few.problem.each(left_without, names, current, stage=LEAVING_OUT)
            names = [names[k] for k in np.argsort(left, kind="stable")[:WEAKEST]]
        trials = problem.each(roughly_without, names, current, stage=LEAVING_OUT)
        if few:
            near = [c for c in trials if effect_size(c, current) <= PLAINLY * limit]
            trials = problem.each(to_the_end, range(len(near)), near, stage=LEAVING_OUT)
        able = sorted((c for c in trials if effect_size(c, current) <= limit), key=lambda c: c.mse)
        easiest = next((c for c in able if not makes_up(current, c, problem, limit)), None)
        if easiest is None:
            return current
        current = easiest
    return current
