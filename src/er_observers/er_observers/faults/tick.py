"""One sample of the fault estimator in one compiled call: motion, regression, blocks; and, per block, a verdict.

The memory between samples is one array: what is counted (8,), how the road bends, the follower, verdict, what is
expected (N,), the block that fills up, what the healthy damper has taught (SIZE,), number, sum and sum of squares of
the duties with a field, and the samples of the block. The window of finished blocks, each its sum and its samples,
changes once a block only and is kept apart. After a cut the samples since then are followed anew at the end of every
block, with what is expected by then: rows are derivatives, and those of a healthy damper lead a faulty one astray.
"""

from __future__ import annotations

import math

import numpy as np
from er_models.model import Array

from er_observers.faults import follow
from er_observers.faults.decision import (
    COLOUR,
    DOUBTED,
    KIND,
    LEAST_MISFIT,
    LENGTH,
    MISFIT,
    RESIDUAL,
    SINGLE,
    TRIED,
    decide,
)
from er_observers.faults.evidence import NONE, free
from er_observers.faults.passage import STATES, V
from er_observers.faults.regression import SIGMA
from er_observers.faults.sums import ROWS, SIZE, N, add, misfit
from er_observers.observers.compiled import compiled
from er_observers.observers.copies import add_row, copy_row, scale_row

_SAME = 0.1
"""Spread of duties over their mean below which they are one: a law of the field could be anything between."""
_TRIES, _LOOSE, _TIGHTER, _EARLY, _FAR = 2, 0.1, 0.3, 5, 2.0
"""How often, how far from what is believed (over the whole yield force), and for how many blocks a beginning is looked
for, and the misfit that asks for it."""
FIRST = (1.0, 1.0, 0.5)
"""Bends of the road within a sample at first, see `follow.Belief`: those of a smooth road, and much besides."""
_LEAST, _MOST, _PACE = 3e-3, 3.0, 0.3
"""Least and greatest bend besides that is believed, and how fast it is learnt, per block."""
_UNSURE, _RECENT, _ODD = 1.0, 0.98, 9.0
"""Deviation of the first two bends at first, what a block leaves of what was learnt of them, and the square of an
innovation over its variance beyond which it counts less."""
BLOCKS = 60
"""Blocks the window can hold."""
WITHIN = 20
"""Samples of a block."""
HELD, LASTED, COUNTS, BEGINS = range(follow.SEEN, follow.SEEN + 4)
"""Places in a sample behind what was seen: duty in force, length [s], whether it counts (1) or not (0), and in the
first of a block whether the motion begins with it (1)."""
TOLD = follow.SEEN + 4
"""Places of a sample."""
DUTY, FILLED, COUNT, HEAD, QUIET, SHAKEN, MISSED, MOVES = range(8)
"""Counted: duty in force; samples in the block; blocks in the window, place of the newest, blocks since the window was
last cut, mean square of the velocity [m2/s2]; by how much squared innovations of the motion were beyond their variances
in this block, weighted with the share of the bends in them, and the sum of these weights."""
COUNTED = slice(0, 8)
BENDS = slice(8, 8 + follow.BENDS)
LEARNT = slice(BENDS.stop, BENDS.stop + 5)
"""Bends, see `follow.Belief`; what is known of the first two: lower triangle of their information, and its vector."""
MIND = slice(LEARNT.stop, LEARNT.stop + follow.SIZE)
VERDICT = slice(MIND.stop, MIND.stop + LENGTH)
EXPECTED = slice(VERDICT.stop, VERDICT.stop + N)
BLOCK = slice(EXPECTED.stop, EXPECTED.stop + SIZE)
TAUGHT = slice(BLOCK.stop, BLOCK.stop + SIZE)
LEVELS = slice(TAUGHT.stop, TAUGHT.stop + 3)
RAW = slice(LEVELS.stop, LEVELS.stop + WITHIN * TOLD)
MEMORY = RAW.stop
STORED = SIZE + WITHIN * TOLD
"""Places of a block in the window: its sum, and its samples."""
ROOM = 4 * N + N * N + 2 * SIZE
FORCE, VARIANCE, CUT, LEAST, KEPT, CALM, FRESH, ANEW, FADING, REAL = range(10)
"""Places in the set-up (10,): noise of a given force, 0 for none; variance of the force [N2]; misfit that cuts the
window, blocks before a verdict, share of the lessons kept per block, blocks kept in the window while all is well,
blocks that are too young for lessons when the window is cut, blocks after a cut in which all is followed anew,
share of a sample in the mean square of the velocity, and that over its variance below which samples do not count: the
gate sees noise, which as a column of the regression would look like a lost force."""
SETUP = REAL + 1


@compiled
def place(p: Array, noise: Array, x: float, v: float, memory: Array) -> None:
    """Let the motion begin with x and v (NaN: unknown); what is known of the damper stays."""
    follow.begin(p, noise, x, v, memory[MIND])
    memory[COUNTED][FILLED] = memory[COUNTED][MISSED] = memory[COUNTED][MOVES] = 0.0
    memory[BLOCK] = 0.0
    memory[RAW][BEGINS] = 1.0


@compiled
def run(
    p: Array, noise: Array, setup: Array, a: tuple[float, float], seen: tuple[float, float],
    duty: float, force: float, dt: float, memory: Array,
) -> bool:  # fmt: skip
    """Bring the memory dt [s] on with a sample, in place; whether a block is full.

    a: sprung and unsprung acceleration, seen: deflection and velocity; all may be NaN, as may the force.
    """
    counted, mind, raw = memory[COUNTED], memory[MIND], memory[RAW].reshape((WITHIN, TOLD))
    told = raw[int(counted[FILLED])]
    told[follow.BODY_SEEN], told[follow.WHEEL_SEEN] = a
    told[follow.X_SEEN], told[follow.V_SEEN] = seen
    told[follow.FORCE_SEEN], told[HELD], told[LASTED] = force, counted[DUTY], dt
    rows = np.empty((3, follow.ROW))
    rig = follow.Rig(p, noise, setup[FORCE])
    belief = follow.Belief(memory[EXPECTED], 0.0, memory[BENDS])
    follow.advance(rig, belief, follow.Step(told[: follow.SEEN], counted[DUTY], dt), mind, rows)
    v, variance = mind[V], mind[follow.COVARIANCE][V * STATES + V]
    counted[SHAKEN] += setup[FADING] * (v * v - counted[SHAKEN])
    told[COUNTS] = 1.0 if counted[SHAKEN] > setup[REAL] * variance else 0.0
    if told[COUNTS] > 0.0:
        _compare(memory, rows)
        _add(memory[BLOCK], rows, memory[EXPECTED])
        _count(memory[LEVELS], counted[DUTY])
    counted[DUTY] = duty
    counted[FILLED] += 1.0
    return bool(counted[FILLED] >= WITHIN)


@compiled
def _compare(memory: Array, rows: Array) -> None:
    """Count what the motion's innovations say of the road's bends, in place."""
    counted, known, learnt = memory[COUNTED], memory[BENDS], memory[LEARNT]
    for q in range(2):
        variance = rows[q, N + 1]
        if variance > 0.0:
            first, second, rest = rows[q, N + 2], rows[q, N + 3], rows[q, N + 4]
            square = rows[q, N] ** 2 / variance
            share = rest * rest / variance
            counted[MISSED] += share * (square - 1.0)
            counted[MOVES] += share
            weight = (1.0 if square < _ODD else _ODD / square) / variance
            y = rows[q, N] + first * known[0] + second * known[1]
            learnt[0] += weight * first * first
            learnt[1] += weight * first * second
            learnt[2] += weight * second * second
            learnt[3] += weight * first * y
            learnt[4] += weight * second * y


@compiled
def _learn_the_road(setup: Array, memory: Array) -> None:
    """Let the bends be what the motion's innovations say, unless the damper has just changed; in place."""
    counted, known, learnt = memory[COUNTED], memory[BENDS], memory[LEARNT]
    if counted[QUIET] > setup[ANEW] and counted[MOVES] > 0.0:
        beyond = min(max(counted[MISSED] / counted[MOVES], -1.0), 1.0)
        known[2] = min(max(known[2] * math.exp(_PACE * beyond), _LEAST), _MOST)
        sure = _UNSURE**-2
        a, b, c = learnt[0] + sure, learnt[1], learnt[2] + sure
        one, two, whole = learnt[3] + sure, learnt[4] + sure, a * c - b * b
        known[0] = (c * one - b * two) / whole
        known[1] = (a * two - b * one) / whole
    for i in range(learnt.size):
        learnt[i] *= _RECENT
    counted[MISSED] = counted[MOVES] = 0.0


@compiled
def _add(block: Array, rows: Array, known: Array) -> None:
    """Add the rows of a sample to a sum, in place; one that surprises counts less (Huber 1964)."""
    for q in range(rows.shape[0]):
        row = rows[q]
        if row[N + 1] > 0.0:
            square = row[N] ** 2 / row[N + 1]
            weight = 1.0 if square < _ODD else math.sqrt(_ODD / square)
            add(block, row[:N], row[N] + row[:N] @ known, weight / row[N + 1])


@compiled
def _anew(
    p: Array, noise: Array, setup: Array, loose: float, window: Array, memory: Array, total: Array
) -> None:
    """Follow the samples of the window again, with what is expected now; fill their sum (SIZE,).

    Where the motion began anew it does so here, and nothing before says anything of it.
    """
    counted, mind = memory[COUNTED], memory[MIND]
    head, count = int(counted[HEAD]), int(counted[COUNT])
    rows, begun, now = np.empty((3, follow.ROW)), False, mind.copy()
    rig = follow.Rig(p, noise, setup[FORCE])
    belief = follow.Belief(memory[EXPECTED], loose, memory[BENDS])
    for i in range(count - 1, -1, -1):
        stored = window[(head - i) % BLOCKS]
        raw = stored[SIZE:].reshape((WITHIN, TOLD))
        stored[:SIZE] = 0.0
        begun = begun and raw[0, BEGINS] <= 0.0
        for k in range(WITHIN):
            if begun:
                step = follow.Step(raw[k, : follow.SEEN], raw[k, HELD], raw[k, LASTED])
                follow.advance(rig, belief, step, mind, rows)
                if raw[k, COUNTS] > 0.0:
                    _add(stored[:SIZE], rows, memory[EXPECTED])
            elif math.isfinite(raw[k, follow.X_SEEN]):
                begun = True
                follow.begin(p, noise, raw[k, follow.X_SEEN], raw[k, follow.V_SEEN], mind)
    if not begun:  # no deflection was seen in the last blocks: their motion is known as it was
        copy_row(now, mind)
    _sum_up(window, memory, total)


@compiled
def _sum_up(window: Array, memory: Array, total: Array) -> None:
    """Fill the sum (SIZE,) of the window."""
    counted = memory[COUNTED]
    total[:] = 0.0
    for i in range(int(counted[COUNT])):
        add_row(window[(int(counted[HEAD]) - i) % BLOCKS, :SIZE], total)


def _begin_again(
    p: Array, noise: Array, setup: Array, first: Array, room: Array, window: Array, memory: Array
) -> None:
    """Find a beginning for unknowns that may be far off, with a motion that hardly goes by them."""
    total, rest = room[2 * N : 2 * N + SIZE], room[2 * N + 2 * SIZE :]
    for k in range(_TRIES):
        loose = _LOOSE * p[SIGMA] * _TIGHTER**k
        _anew(p, noise, setup, loose, window, memory, total)
        free(total, first, 1.0, rest)
        memory[EXPECTED] = rest[N : 2 * N]


@compiled
def _count(levels: Array, duty: float) -> None:
    """Count a duty with a field, in place."""
    if duty > 0.0:
        levels[0] += 1.0
        levels[1] += duty
        levels[2] += duty * duty


@compiled
def _single(levels: Array) -> float:
    """1 where the duties with a field were all alike."""
    if levels[0] <= 0.0:
        return 1.0
    mean = levels[1] / levels[0]
    return 1.0 if levels[2] / levels[0] < (1.0 + _SAME**2) * mean * mean else 0.0


def _moved(counted: Array, window: Array) -> bool:
    """Whether any sample counts in the window: one that holds none begins with the motion, as after a cut."""
    places = (int(counted[HEAD]) - np.arange(int(counted[COUNT]))) % BLOCKS
    return bool(np.any(window[places, ROWS] > 0.0))


def close(
    p: Array, noise: Array, setup: Array, rules: Array, prior: Array, first: Array, room: Array,
    window: Array, memory: Array,
) -> None:  # fmt: skip
    """Put the full block into the window (BLOCKS, STORED), what leaves it into the lessons, and judge, in place.

    Not compiled as one, for every copy of the motion in compiled code takes seconds to compile.
    """
    counted, verdict, block = memory[COUNTED], memory[VERDICT], memory[BLOCK]
    ones, total = room[N : 2 * N], room[2 * N : 2 * N + SIZE]
    ones[:] = 1.0
    surprise = misfit(block, ones, memory[EXPECTED]) / max(block[ROWS], 1.0)
    counted[QUIET] += 1.0
    enough = block[ROWS] >= 0.5 * WITHIN
    if enough and not _moved(counted, window):
        counted[COUNT], counted[QUIET] = 0.0, 1.0
    elif (
        enough
        and counted[QUIET] > setup[LEAST]
        and surprise > setup[CUT] * max(verdict[MISFIT], 1.0)
    ):
        _shorten(setup, rules, int(setup[FRESH]), window, memory)
        counted[COUNT], counted[QUIET] = 0.0, 0.0
    elif _well(verdict):
        _shorten(setup, rules, int(setup[CALM]) - 1, window, memory)
    _learn_the_road(setup, memory)
    head = int(counted[HEAD])
    if counted[QUIET] > 0.0:  # a cut lies within its block
        head = (head + 1) % BLOCKS
        window[head, :SIZE], window[head, SIZE:] = block, memory[RAW]
        counted[HEAD], counted[COUNT] = head, min(counted[COUNT] + 1.0, float(BLOCKS))
    block[:] = 0.0
    counted[FILLED] = memory[RAW][BEGINS] = 0.0
    if counted[COUNT] < setup[LEAST]:
        return
    young = counted[COUNT] == counted[QUIET] and counted[COUNT] <= setup[ANEW]
    if (
        young
        and counted[COUNT] <= _EARLY
        and (counted[COUNT] == setup[LEAST] or verdict[MISFIT] > _FAR)
    ):
        _begin_again(p, noise, setup, first, room, window, memory)
    if young:
        _anew(p, noise, setup, 0.0, window, memory, total)
    else:
        _sum_up(window, memory, total)
    _conclude(setup, rules, prior, first, room, memory)


@compiled
def _conclude(
    setup: Array, rules: Array, prior: Array, first: Array, room: Array, memory: Array
) -> None:
    """The verdict on the total that lies in the room."""
    total, belief = room[2 * N : 2 * N + SIZE], room[2 * N + SIZE : 2 * N + 2 * SIZE]
    copy_row(prior, belief)
    add_row(memory[TAUGHT], belief)
    rest, verdict = room[2 * N + 2 * SIZE :], memory[VERDICT]
    scale_row(setup[KEPT], memory[LEVELS])
    verdict[SINGLE] = _single(memory[LEVELS])
    moved = memory[RAW].reshape((WITHIN, TOLD))[:, COUNTS].mean()
    decide(rules, total, belief, first, moved, verdict, rest)
    for i in range(N):
        rest[i] *= rest[N + i]
    expect(memory, rest[:N])
    verdict[RESIDUAL] = math.sqrt(max(verdict[MISFIT] - 1.0, 0.0) * setup[VARIANCE])


@compiled
def expect(memory: Array, known: Array) -> None:
    """Go by these unknowns (N,) from now on; the motion follows as far as it leans on them."""
    expected, mind = memory[EXPECTED], memory[MIND]
    z, S = mind[follow.STATE], mind[follow.LEAN].reshape((STATES, N))
    for i in range(N):
        for j in range(STATES):
            z[j] += S[j, i] * (known[i] - expected[i])
        expected[i] = known[i]


@compiled
def _well(verdict: Array) -> bool:
    """Whether the damper is healthy and nothing speaks against it."""
    return int(verdict[KIND]) == NONE and int(verdict[TRIED]) == NONE and verdict[DOUBTED] <= 0.0


@compiled
def _shorten(setup: Array, rules: Array, keep: int, window: Array, memory: Array) -> None:
    """Let all blocks but the newest `keep` leave the window, into the lessons if all is well."""
    counted, verdict, taught = memory[COUNTED], memory[VERDICT], memory[TAUGHT]
    head, count = int(counted[HEAD]), int(counted[COUNT])
    for i in range(keep, count):
        if _well(verdict):
            divisor = rules[COLOUR] * max(verdict[MISFIT], LEAST_MISFIT)
            for j in range(SIZE):
                taught[j] = setup[KEPT] * taught[j] + window[(head - i) % BLOCKS, j] / divisor
    counted[COUNT] = min(count, keep)
