"""Whether an effect is there: large beside what chance gives, and steady over blocks."""

from __future__ import annotations

import numpy as np
from er_models.model import Array

from er_model_lab.diagnosis.candidates import (
    Candidate,
    effect_size,
)
from er_model_lab.diagnosis.null import Null
from er_model_lab.diagnosis.rule import RULE, Rule
from er_model_lab.problem.problem import Problem

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
PARTS, UNDERRATED = 10, 4.0
"""Parts of the samples, by what the errors of the motion cause there, in which a gain must exceed it, and how much more
in mean square these errors may cause than the fusion says."""


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
