"""Which effects to add: forward one at a time, pairs where one is not enough, backward, and ties."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from er_models.model import Array, Model

from er_model_lab.diagnosis.candidates import (
    Candidate,
    chosen_among,
    effect_size,
    finished,
    left_without,
    refit,
    roughly_without,
    screen,
    to_the_end,
)
from er_model_lab.diagnosis.determined import far, loose, strange, unseen
from er_model_lab.diagnosis.null import Null, simulate_null
from er_model_lab.diagnosis.ranking import refit_all
from er_model_lab.diagnosis.refinements import NOTHING, makes_up, stands_in
from er_model_lab.diagnosis.rule import BAND, RULE, Rule
from er_model_lab.fitting.fit import mean_square, standard_deviations
from er_model_lab.problem.problem import Problem

PAIRS_OF = 6
"""Pairs are tried among this many best singles."""
WEAKEST = 2
"""Effects that are left out on all of many runs, those that stretches need least."""
PLAINLY = 2.0
"""Size, over what counts, from which on an effect is needed by a fit in longer steps alone."""
LEAVING_OUT = "leaving effects out"
MOST_EFFECTS = 3
BEYOND, FAR_BEYOND = 2.5, 3.0
"""Size, over what chance gives, from which on less steadiness is asked of an effect, and of one that is there however
unevenly its gains are spread. So much must a generalised form gain over its special case, too: the name then rests on
one number alone."""
STEADY, LESS_STEADY = 3.0, 2.0
"""Paired t of gains over blocks [1] above which chance does not make them: three standard errors; and two of them for
small steps, which held-out data confirm or refuse."""
NEARLY_ALL, HALF = 0.8, 0.5
"""Shares of blocks that gain: from the first on an effect is steady, below the second it is none, however large."""
FEW = 3
"""Samples on end that may be wild, or bent by a filter, without being known as such."""
HARMLESS = 0.05
"""Share of its gains that an effect which acts seldom may lose elsewhere."""
PROMISE = 1.5
"""Size, over what chance gives, from which a candidate left over is worth another round."""
DOUBT, SURE = 2.0, 4.5
"""Paired t below which two candidates are tied in any case, and from which on they never are."""
NEARLY = 0.85
"""Share of the best one's effect size from which on a candidate comes near it."""
FORM, TWIN, SPARE = 0.997, 0.99, 1.5
"""Shares of the best one's effect size that a form of fewer parameters, which is named first then, and one of as many
have, and the most by which either is behind, over what counts as an effect, where the two are tied: what is real keeps
to no equation, and no sensor to its noise, so closely that it would decide."""
NOTED = 1.15
"""Times what the best candidate leaves, from which on one that is tied with it is told after it."""
PARTS, UNDERRATED = 10, 4.0
"""Parts of the samples, by what the errors of the motion cause there, in which a gain must exceed it, and how much more
in mean square these errors may cause than the fusion says."""
NESTED, SAME = 1e-2, 1e-4
"""Mean square of the difference of two forces, over what is left, below which they are nearly, and wholly, the same."""


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


def threshold(null: Null, floor: float, rule: Rule = RULE) -> float:
    """Smallest effect size that counts [N]."""
    return max(null.threshold(rule.false_alarm), rule.smallest * floor)


def passes(base: Candidate, candidate: Candidate, limit: float, steady: float = STEADY) -> bool:
    """Whether an effect is there: large, and steady over blocks; steady: the paired t from which on it is.

    The fall must exceed the limit and be positive in half of the blocks at least. It must also be steady: by its
    paired t, or positive in nearly all blocks, or seldom at work and harmless else. The less is asked of that the
    nearer it comes to far beyond the limit, and nothing from there on (records of different kind, where some cannot
    show the effect).
    """
    size = effect_size(base, candidate)
    if size <= limit:
        return False
    gains = base.losses - candidate.losses
    positive = float(np.mean(gains > 0))
    asked = float(np.interp(size / limit, (BEYOND, FAR_BEYOND), (NEARLY_ALL, HALF)))
    even = paired_t(gains) > steady or seldom(gains, limit)
    return positive >= (HALF if even else asked)


def seldom(gains: Array, limit: float) -> bool:
    """Whether an effect acts in few blocks, but in more than one, and harms nowhere; gains: falls of mean squares.

    What it gains without its best block must still exceed the limit, and what the other blocks lose be next to nothing.
    """
    rest = float(gains.sum() - gains.max()) / gains.size
    return rest > limit**2 and harmless(gains)


def harmless(gains: Array) -> bool:
    """Whether what blocks lose is next to nothing beside what the others gain; gains: falls of mean squares."""
    return -float(gains[gains < 0.0].sum()) < HARMLESS * float(gains[gains > 0.0].sum())


def there(
    base: Candidate, candidate: Candidate, problem: Problem, limit: float, rule: Rule = RULE
) -> bool:
    """Whether an effect passes, and not by a few samples alone."""
    steady = LESS_STEADY if rule.small_steps else STEADY
    return passes(base, candidate, limit, steady) and not momentary(
        base, candidate, problem, limit
    )


def momentary(base: Candidate, candidate: Candidate, problem: Problem, limit: float) -> bool:
    """Whether what an effect gains lies in a few samples, which may be wild, and elsewhere is within the limit."""
    rows = problem.train
    gains = np.where(rows, base.residual**2 - candidate.residual**2, 0.0)
    best = float(np.convolve(gains, np.ones(FEW), "valid").max(initial=0.0))
    return float(gains.sum()) - best <= limit**2 * int(rows.sum())


def beyond_motion(base: Candidate, candidate: Candidate, null: Null, problem: Problem) -> float:
    """Effect size [N] less what the errors of the motion may cause, each where it is.

    They act where the gate closes. An effect that gains on the plateaus of the force is none of theirs, however large
    they are elsewhere; a lag or a delay gains where they act.
    """
    rows = problem.train
    errors = UNDERRATED * null.input_square[rows]
    gains = base.residual[rows] ** 2 - candidate.residual[rows] ** 2
    parts = np.array_split(np.argsort(errors, kind="stable"), PARTS)
    of_motion = [np.clip(gains[p].sum(), 0.0, errors[p].sum()) for p in parts]
    return float(np.sqrt(max(gains.sum() - sum(of_motion), 0.0) / gains.size))


def block_gains(better: Candidate, worse: Candidate, problem: Problem) -> Array:
    """Differences of the mean squared errors of two candidates in blocks of a second; positive: `better` is.

    Of less than four seconds the blocks are quarters.
    """
    rows = problem.train
    d = worse.residual[rows] ** 2 - better.residual[rows] ** 2
    length = min(problem.second, max(d.size // 4, 1))
    means: Array = d[: d.size // length * length].reshape(-1, length).mean(axis=1)
    return means


def paired_t(gains: Array) -> float:
    """Mean of differences over its standard error."""
    return float(gains.mean() / max(float(gains.std(ddof=1)) / np.sqrt(gains.size), 1e-300))


def complexity(candidate: Candidate, problem: Problem) -> tuple[int, int]:
    """Parameters in use, and whether it is physics (1) or a sensor (0): fewer and sensor first.

    A refinement is in use where the data say that it is not neutral; a strength at a bound where that is not doing
    nothing.
    """
    model, fitted = candidate.fit.model, candidate.fit
    free = [(k, *place) for k, place in enumerate(fitted.free) if place[0] in candidate.effects]
    used = [
        (k, model.catalogue[e].parameter(p), e)
        for k, e, p in free
        if acts(model, e, p, bool(fitted.at_bound[k]))
    ]
    if any(q.optional for _, q, _ in used):
        sd = standard_deviations(fitted, problem)
        used = [
            (k, q, e)
            for k, q, e in used
            if not q.optional or abs(model.value(e, q.name) - (q.neutral or 0.0)) > DOUBT * sd[k]
        ]
    return len(used), 0 if model.catalogue[candidate.name].stage == "sensing" else 1


def acts(model: Model, effect: str, name: str, at_bound: bool) -> bool:
    """Whether a parameter counts as one in use: it is free, or a strength at a bound that is not doing nothing."""
    q = model.catalogue[effect].parameter(name)
    if not at_bound or q.optional or q.neutral is None:
        return not at_bound
    low, high = model.bounds(effect, name)
    return abs(model.value(effect, name) - q.neutral) > NOTHING * (high - low)


def tied(
    base: Candidate, candidates: list[Candidate], problem: Problem, limit: float
) -> list[Candidate]:
    """Candidates the data cannot tell from the best one, in the order in which they are told.

    A law of the duty comes last where the duty never changes, before it what held-out data refuse. Those whose values
    the data determine come first, then those that are not plainly worse, those that are not far from doing nothing,
    those that leave little more than the best, and the simplest: with the fewest parameters in use, and at all.

    A tie needs nearly the same effect size, and a paired difference within `DOUBT` standard errors, or within `SURE`
    and too small to count as an effect of its own. A difference that would count, in several blocks and nowhere the
    other way, is not chance, however unevenly it is spread: a stop acts seldom. Nor is one far beyond what counts, in
    half of the blocks at least. Where the motion repeats itself a difference comes back in every cycle, so that only
    its size counts.

    A form of fewer parameters that leaves next to nothing more is tied, too: turbulent damping as v^1.75 is met a
    little better by a power law with a free exponent than by v^2. So is one of as many: beside errors of the motion,
    which smooth what is predicted, a lag of 2 ms may meet a force that is 2 ms late a little better than the delay.
    """
    best = candidates[0]
    size, (used, _) = effect_size(base, best), complexity(best, problem)
    near = [best]

    def behind(other: Candidate) -> float:
        return float(np.sqrt(max(other.left - best.left, 0.0)))

    for other in candidates[1:]:
        gain = effect_size(base, other)
        if not passes(base, other, limit) or gain < NEARLY * size:
            continue
        gap, gains = behind(other), block_gains(best, other, problem)
        doubtful = paired_t(gains) < (SURE if gap < limit else DOUBT) and not seldom(gains, limit)
        doubtful = doubtful and not (gap > FAR_BEYOND * limit and np.mean(gains > 0.0) >= HALF)
        more = complexity(other, problem)[0] - used
        spare = more <= 0 and gain > (FORM if more else TWIN) * size and gap < SPARE * limit
        if doubtful or spare or (problem.cycles and gap < limit):
            near.append(other)
    unsure = {c.name for c in near if len(near) > 1 and c.name in loose(c, problem)}
    return sorted(
        near,
        key=lambda c: (
            unseen(c, problem),
            rises(base, c, problem),
            c.name in unsure,
            plainly_worse(c, best, problem),
            far(c),
            behind(c) > FAR_BEYOND * limit,
            *complexity(c, problem),
            disguised(c, near, problem),
            len(c.fit.model.catalogue[c.name].parameters),
        ),
    )


def rises(before: Candidate, after: Candidate, problem: Problem) -> bool:
    """Whether the error on held-out data rises from one model to another by more than a share: they refuse it."""
    if not problem.held_out.any():
        return False
    old, new = (mean_square(c.fit.residual[problem.held_out]) for c in (before, after))
    return new > (1.0 + BAND) ** 2 * old


def plainly_worse(other: Candidate, best: Candidate, problem: Problem) -> bool:
    """Whether a candidate leaves more than the best one by more than noise, and in nearly all blocks.

    What errors of the motion may cause leaves both tied, however sure noise alone would be.
    """
    gains = block_gains(best, other, problem)
    steady = paired_t(gains) >= DOUBT and float(np.mean(gains > 0.0)) >= NEARLY_ALL
    return steady and other.left > NOTED**2 * best.left


def nested(simple: Candidate, rich: Candidate, problem: Problem) -> bool:
    """Whether two candidates make nearly the same force, so that one contains the other.

    What acts in the car and what acts in the damper are no forms of one another, however alike; nor are two
    effects of as many parameters in use: neither is the simpler, unless bounds make the one the very same as the other.
    """
    alike = NESTED
    if complexity(simple, problem)[0] == complexity(rich, problem)[0]:
        alike = SAME
        if len(simple.fit.free) >= len(rich.fit.free):
            return False
    stages = [c.fit.model.catalogue[c.name].stage == "vehicle" for c in (simple, rich)]
    if stages[0] != stages[1]:
        return False
    rows = problem.train
    change = simple.fit.residual[rows] - rich.fit.residual[rows]
    return bool(
        np.mean(change**2) < alike * max(float(np.mean(simple.residual[rows] ** 2)), 1e-300)
    )


def disguised(rich: Candidate, others: list[Candidate], problem: Problem) -> bool:
    """Whether bounds make a form into a simpler one of these: Stribeck without breakaway is Coulomb friction."""
    own = complexity(rich, problem)
    return any(
        complexity(other, problem) == own and nested(other, rich, problem) for other in others
    )


def rivals(simple: Candidate, rich: Candidate, problem: Problem) -> bool:
    """Whether a tie is worth telling: of nested forms the simpler stands for both, unless the data ask for more."""
    return (
        not nested(simple, rich, problem) or paired_t(block_gains(rich, simple, problem)) >= DOUBT
    )


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
    ended = {c.name: chosen_among(c, problem) for c in refined}
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

    target: mean square [N2] that it must promise on stretches of many runs to be fitted to the end.
    """
    effect = rest.fit.model.catalogue[name]
    found = chosen_among(refit(rest, effect, problem, max_iter=20, target=target), problem)
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
