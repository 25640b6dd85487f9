"""Which of several effects the data cannot tell apart, and which of them is told first."""

from __future__ import annotations

import numpy as np
from er_models.model import Model

from er_model_lab.diagnosis.candidates import (
    Candidate,
    effect_size,
)
from er_model_lab.diagnosis.determined import far, loose, unseen
from er_model_lab.diagnosis.passing import (
    FAR_BEYOND,
    HALF,
    NEARLY_ALL,
    block_gains,
    paired_t,
    passes,
    seldom,
)
from er_model_lab.diagnosis.refinements import NOTHING
from er_model_lab.diagnosis.rule import BAND
from er_model_lab.fitting.deviations import standard_deviations
from er_model_lab.fitting.fit import mean_square
from er_model_lab.problem.problem import Problem

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
NESTED, SAME = 1e-2, 1e-4
"""Mean square of the difference of two forces, over what is left, below which they are nearly, and wholly, the same."""


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
