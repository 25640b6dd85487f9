r"""From a stretch of time to a verdict: probabilities of the kinds, factors, statuses with hysteresis, compiled.

The factors are means over the kinds, weighted with their probabilities, and so are their deviations; of a factor that
nothing excites the last one stays. A kind is named when it has been the most probable one, and sure, for a while.
What neither faults nor the tolerance of the model explain is judged beside it: residual and unknowns beyond belief.
"""

from __future__ import annotations

import math

import numpy as np
from er_models.model import Array

from er_observers.faults.evidence import (
    COMBINED,
    DEFORMATION,
    ELECTRICAL,
    KINDS,
    LEAKAGE,
    NONE,
    combined,
    log_evidence,
    shares_of,
    single,
    unknowns,
)
from er_observers.faults.sums import ROWS, N, misfit
from er_observers.observers.compiled import compiled
from er_observers.observers.copies import copy_row

UNKNOWN, HEALTHY, SUSPECTED, CONFIRMED, NOT_EXCITED, CONFOUNDED = range(6)
"""Statuses of a factor, as FAULT_* of the message."""
KIND, CERTAINTY, TRIED, TRIALS, MISFIT, RESIDUAL, RATIO, DOUBTS, DOUBTED = range(9)
FACTORS, SPREAD, STATUS, EXCITED, OWN, PROBABILITY = (
    slice(9, 12), slice(12, 15), slice(15, 18), slice(18, 21), slice(21, 24), slice(24, 29),
)  # fmt: skip
SINGLE, SEEN, SHARES = 29, 30, slice(31, 34)
LENGTH = 34
"""Places in a verdict (34,). DOUBTED: for how many blocks of motion something has been in doubt, 0: nothing is.
OWN: factor of each fault if it is the only one; SINGLE: whether the field has had one strength only; SEEN: whether the
damper was healthy once while its field could be seen; SHARES: likeliest ones of several faults."""
SOME = -2
"""Kind of a fault that is sure, but which one is not; -1 is nothing known yet."""
_KEPT = 0.5
"""Probability that a named kind keeps its name with."""
ORDER = (ELECTRICAL, LEAKAGE, DEFORMATION)
(
    SURE, BLOCKS_IN_A_ROW, SMALLEST, KNOWN, LOST, LIMIT, BELIEF, COLOUR, HEALTHY_ODDS, COMBINED_ODDS, AGAIN,
) = range(11)  # fmt: skip
"""Places in the rules (11,), see `rules.Rules`; the odds are over those of each single fault."""
RULES = AGAIN + 1
GATE, _FURTHER = N - 2, 1.15
"""Place of the first unknown of the gate, and how much further from what was believed the gate may be: rough roads bend
it, see `rules`."""
LEAST_MISFIT = 0.5
"""Squared residuals over noise that are believed; smaller ones are chance."""


def begin() -> Array:
    """The verdict (LENGTH,) before any sample: nothing is known, healthy is the likeliest."""
    verdict = np.zeros(LENGTH)
    verdict[KIND], verdict[MISFIT] = -1.0, 1.0
    verdict[FACTORS], verdict[SPREAD] = 1.0, 1.0 / math.sqrt(12.0)
    verdict[OWN], verdict[STATUS], verdict[SHARES] = 1.0, UNKNOWN, 1.0
    return verdict


@compiled
def decide(
    rules: Array,
    total: Array,
    prior: Array,
    first: Array,
    moved: float,
    verdict: Array,
    room: Array,
) -> None:
    """Bring the verdict (LENGTH,) up to date with a stretch of time, in place.

    prior: what is believed of the healthy damper, a sum; first (2 N,): mean and deviation of each unknown
    before any sample; moved: share of the last block in which the car moved; room (2 N + N N,): left with the
    unknowns of the likeliest kind and their scale.
    """
    temper = 1.0 / (rules[COLOUR] * max(verdict[MISFIT], LEAST_MISFIT))
    log_z, alone, factors, spread = np.empty(KINDS), np.empty(3), np.empty(3), np.empty(3)
    shares = np.ones(3)
    log_z[NONE] = math.log(rules[HEALTHY_ODDS]) + log_evidence(total, prior, temper, shares, room)
    for i in range(3):
        kind = i + 1
        start = min(max(verdict[OWN][i], 0.3), 1.0)
        s, alone[i], log_z[kind] = single(kind, total, prior, temper, start, room)
        verdict[OWN][i] = s
    best = int(np.argmax(log_z[1:4])) + 1
    shares_of(best, min(max(verdict[OWN][best - 1], 0.1), 1.0), shares)
    _begin_with(total, prior, temper, verdict[SHARES], shares, room)
    log_z[COMBINED] = math.log(rules[COMBINED_ODDS])
    log_z[COMBINED] += combined(total, prior, temper, shares, room, factors, spread)
    copy_row(shares, verdict[SHARES])
    _normalise(log_z, verdict[PROBABILITY])
    _mix(rules, alone, factors, spread, verdict)
    likely = int(np.argmax(verdict[PROBABILITY]))
    _judge(rules, total, prior, first, temper, likely, factors, verdict, room)
    _doubt(rules, moved, verdict)
    _name(rules, likely, verdict)
    _states(rules, verdict)


@compiled
def _normalise(log_z: Array, p: Array) -> None:
    """Probabilities p (KINDS,) of the kinds from the logarithms of their evidence."""
    most, total = np.max(log_z), 0.0
    for i in range(KINDS):
        p[i] = math.exp(log_z[i] - most)
        total += p[i]
    for i in range(KINDS):
        p[i] /= total


@compiled
def _begin_with(
    total: Array, prior: Array, temper: float, before: Array, shares: Array, room: Array
) -> None:
    """Leave in shares (3,) the likelier of them and those of the verdict before: the way to both is long and narrow."""
    if log_evidence(total, prior, temper, before, room) > log_evidence(
        total, prior, temper, shares, room
    ):
        copy_row(before, shares)


@compiled
def _mix(rules: Array, alone: Array, factors: Array, spread: Array, verdict: Array) -> None:
    """Factors and deviations over all kinds; excitation of each with its hysteresis."""
    p = verdict[PROBABILITY]
    for i in range(3):
        limit = rules[LOST] if verdict[EXCITED][i] > 0.0 else rules[KNOWN]
        verdict[EXCITED][i] = 1.0 if alone[i] < limit else 0.0
        if verdict[EXCITED][i] <= 0.0:
            continue
        own = min(max(verdict[OWN][i], 0.0), 1.0)
        rest = 1.0 - p[i + 1] - p[COMBINED]
        mean = p[i + 1] * own + p[COMBINED] * factors[i] + rest
        spare = p[i + 1] * (own - mean) ** 2 + rest * (1.0 - mean) ** 2 + alone[i] ** 2
        spare += p[COMBINED] * (min(spread[i], 0.5) ** 2 + (factors[i] - mean) ** 2)
        verdict[FACTORS][i], verdict[SPREAD][i] = mean, math.sqrt(spare)


@compiled
def _judge(
    rules: Array, total: Array, prior: Array, first: Array, temper: float, kind: int,
    factors: Array, verdict: Array, room: Array,
) -> None:  # fmt: skip
    """What this kind leaves unexplained: squared residual over noise, and unknowns beyond belief."""
    shares = np.ones(3)
    if kind == COMBINED:
        shares[0], shares[1] = factors[1], factors[1] * factors[2]
        shares[2] = shares[1] * factors[0]
    elif kind != NONE:
        shares_of(kind, min(max(verdict[OWN][kind - 1], 0.0), 1.0), shares)
    unknowns(total, prior, temper, shares, room)
    beta, beyond = room[N : 2 * N], 0.0
    for i in range(N):
        limit = rules[BELIEF] * (_FURTHER if i >= GATE else 1.0)
        beyond = max(beyond, abs(beta[i] - first[i]) / (limit * first[N + i]))
    verdict[MISFIT] = misfit(total, room[:N], beta) / max(total[ROWS], 1.0)
    verdict[RATIO] = max(math.sqrt(max(verdict[MISFIT], 0.0)) / rules[LIMIT], beyond)


@compiled
def _name(rules: Array, likely: int, verdict: Array) -> None:
    """Name a kind once it has been likely and sure for long enough; a sure fault of an unsure kind is `SOME`."""
    p, named = verdict[PROBABILITY], int(verdict[KIND])
    if likely not in (NONE, COMBINED) and verdict[OWN][likely - 1] > 1.0 - rules[SMALLEST]:
        likely = NONE
    calm = p[NONE]  # a factor that nothing excites speaks for no fault
    for i in range(3):  # nor does one that has lost too little
        little = verdict[OWN][i] > 1.0 - rules[SMALLEST]
        calm += p[i + 1] * (1.0 if little else 1.0 - verdict[EXCITED][i])
    sure = (calm if likely == NONE else p[likely]) >= rules[SURE]
    if not sure and calm < 1.0 - rules[SURE] and (named <= NONE or p[named] < _KEPT):
        likely, sure = SOME, True
    blind = named in ORDER and verdict[EXCITED][named - 1] <= 0.0
    sure = sure and not (blind and likely == NONE)
    sure = sure and not (
        likely != NONE and verdict[DOUBTS] > 0.0
    )  # first see whether it is no fault
    same = likely == int(verdict[TRIED]) and sure
    verdict[TRIALS] = verdict[TRIALS] + 1.0 if same else (1.0 if sure else 0.0)
    verdict[TRIED] = likely
    if verdict[TRIALS] >= rules[BLOCKS_IN_A_ROW]:
        verdict[KIND] = likely
    named = int(verdict[KIND])
    verdict[CERTAINTY] = p[named] if named >= 0 else 0.0


@compiled
def _doubt(rules: Array, moved: float, verdict: Array) -> None:
    """Doubt that this explains all, and take it back, when it has been so for a while; count how long it moved."""
    step = 1.0 if verdict[RATIO] > 1.0 else (-1.0 if verdict[RATIO] < rules[AGAIN] else 0.0)
    if _weak_from_the_start(rules, verdict):
        step = 1.0
    verdict[DOUBTS] = min(max(verdict[DOUBTS] + step, 0.0), 2.0 * rules[BLOCKS_IN_A_ROW])
    if verdict[DOUBTS] <= 0.0:
        verdict[DOUBTED] = 0.0
    elif verdict[DOUBTED] > 0.0:
        verdict[DOUBTED] += moved
    elif verdict[DOUBTS] >= rules[BLOCKS_IN_A_ROW]:
        verdict[DOUBTED] = 1.0


@compiled
def _weak_from_the_start(rules: Array, verdict: Array) -> bool:
    """Whether a lost field was never seen whole, at one strength only: a wrong law of the field looks just so."""
    if int(verdict[KIND]) == NONE and verdict[EXCITED][0] > 0.0:
        verdict[SEEN] = 1.0
    never = verdict[SINGLE] > 0.0 and verdict[SEEN] <= 0.0
    return bool(never and verdict[FACTORS][0] < 1.0 - rules[SMALLEST])


@compiled
def _states(rules: Array, verdict: Array) -> None:
    """Status of each factor."""
    named, p = int(verdict[KIND]), verdict[PROBABILITY]
    for i in range(3):
        lost = verdict[FACTORS][i] < 1.0 - rules[SMALLEST]
        mine = named in (i + 1, COMBINED) and lost
        if verdict[EXCITED][i] <= 0.0:
            status = NOT_EXCITED
        elif named == -1:
            status = UNKNOWN
        elif mine and verdict[DOUBTED] <= 0.0 and p[named] >= rules[SURE]:
            status = CONFIRMED
        elif not lost:
            status = HEALTHY
        elif verdict[DOUBTED] > 0.0:
            status = SUSPECTED
        elif named == SOME or (np.max(p) < rules[SURE] and p[NONE] < 1.0 - rules[SURE]):
            status = CONFOUNDED
        else:
            status = SUSPECTED
        verdict[STATUS][i] = status
