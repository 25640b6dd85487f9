"""One sample of the fault estimator in one compiled call: motion, regression, blocks; and, per block, a verdict.

The memory between samples is one array: what is counted (9,), fluid (6,), verdict, what is expected (N,), how F_er
leans on it (N,), the block that fills up, what the healthy damper has taught (SIZE,), number, sum and sum of squares of
the duties with a field, the trail of the smoother. The window of finished blocks (BLOCKS, SIZE) changes once a block
only and is kept apart.
"""

from __future__ import annotations

import math

from er_models.model import Array

from er_observers.faults import motion
from er_observers.faults.decision import (
    COLOUR,
    KIND,
    LEAST_MISFIT,
    LENGTH,
    MISFIT,
    RESIDUAL,
    SINGLE,
    TRIED,
    UNEXPLAINED,
    decide,
)
from er_observers.faults.evidence import NONE
from er_observers.faults.regression import (
    C0,
    C1,
    DOUBT,
    F_ER,
    K1,
    TAU,
    S,
    advance,
    body_force,
    innovate,
    row,
)
from er_observers.faults.sums import ROWS, SIZE, N, add, misfit
from er_observers.observers.compiled import compiled

_REAL, _FADING = 25.0, 0.05
"""Mean square of the velocity over its variance, and share of a sample in that mean: below, the gate sees noise, which
as a column of the regression would look like a lost force."""
_SAME = 0.1
"""Spread of duties over their mean below which they are one: a law of the field could be anything between."""
BLOCKS = 60
"""Blocks the window can hold."""
X, V, A, DUTY, FILLED, COUNT, HEAD, QUIET, SHAKEN = range(9)
"""Counted: smoothed deflection and velocity, relative acceleration, duty in force then; samples in the block; blocks in
the window, place of the newest, blocks since the window was last cut, mean square of the velocity [m2/s2]."""
COUNTED = slice(0, 9)
FLUID = slice(9, 15)
VERDICT = slice(15, 15 + LENGTH)
EXPECTED = slice(VERDICT.stop, VERDICT.stop + N)
LEAN = slice(EXPECTED.stop, EXPECTED.stop + N)
BLOCK = slice(LEAN.stop, LEAN.stop + SIZE)
TAUGHT = slice(BLOCK.stop, BLOCK.stop + SIZE)
LEVELS = slice(TAUGHT.stop, TAUGHT.stop + 3)
TRAIL = slice(LEVELS.stop, LEVELS.stop + (motion.LAG + 1) * motion.COLUMNS)
MEMORY = TRAIL.stop
ROOM = 4 * N + N * N + 2 * SIZE
FORCE, VARIANCE, ROWS_OF_BLOCK, CUT, LEAST, KEPT, CALM, FRESH = range(8)
"""Places in the set-up (8,): whether the force is given; variance of y [N2]; rows of a block; misfit that cuts the
window, blocks before a verdict, share of the lessons kept per block, blocks kept in the window while all is well,
blocks that are too young for lessons when the window is cut."""


@compiled
def place(p: Array, noise: Array, x: float, v: float, memory: Array) -> None:
    """Let the motion begin with x and v (NaN: unknown); what is known of the damper stays."""
    known = math.isfinite(v)
    trail = memory[TRAIL].reshape((motion.LAG + 1, motion.COLUMNS))
    motion.begin(noise, x, v if known else 0.0, known, trail)
    counted, fluid = memory[COUNTED], memory[FLUID]
    counted[X], counted[V], counted[A] = x, v if known else 0.0, 0.0
    counted[FILLED] = 0.0
    memory[BLOCK] = 0.0
    fluid[:] = 0.0
    memory[LEAN] = 0.0
    fluid[S] = p[K1] * counted[X] + p[C1] * counted[V]


@compiled
def run(
    p: Array, noise: Array, setup: Array, a: tuple[float, float], seen: tuple[float, float],
    duty: float, force: float, dt: float, room: Array, memory: Array,
) -> bool:  # fmt: skip
    """Bring the memory dt [s] on with a sample, in place; whether a block is full.

    a: sprung and unsprung acceleration, seen: deflection and velocity; all may be NaN, as may the force.
    """
    trail = memory[TRAIL].reshape((motion.LAG + 1, motion.COLUMNS))
    relative = a[0] - a[1]
    if not math.isfinite(relative):
        relative = trail[motion.LAG, motion.A_RELATIVE]
    motion.push(noise, trail, relative, seen[0], seen[1], dt)
    last = trail[motion.LAG]
    last[motion.A_SPRUNG], last[motion.DUTY], last[motion.GIVEN] = a[0], duty, force
    if not math.isfinite(a[0]):
        last[motion.GOOD] = 0.0
    return _regress(p, setup, trail, room, memory)


@compiled
def _regress(p: Array, setup: Array, trail: Array, room: Array, memory: Array) -> bool:
    """Add the oldest sample of the trail to the block; whether it is full."""
    counted, fluid, old = memory[COUNTED], memory[FLUID], trail[0]
    if old[motion.DT] <= 0.0:  # the trail is still filling up
        return False
    x_0, v_0, a_0, a_1 = counted[X], counted[V], counted[A], old[motion.A_RELATIVE]
    x, v, variance = motion.smoothed(trail)
    between = variance + motion.between(trail)
    advance(p, fluid, (x_0, x), (v_0, v), (a_0, a_1), between, counted[DUTY], old[motion.DT])
    counted[X], counted[V], counted[A], counted[DUTY] = x, v, a_1, old[motion.DUTY]
    y = old[motion.GIVEN] if setup[FORCE] > 0.0 else body_force(p, x, old[motion.A_SPRUNG])
    lean = memory[LEAN]
    lean *= math.exp(-old[motion.DT] / p[TAU]) if p[TAU] > 0.0 else 0.0
    counted[SHAKEN] += _FADING * (v * v - counted[SHAKEN])
    counted[FILLED] += 1.0
    if old[motion.GOOD] > 0.0 and math.isfinite(y) and counted[SHAKEN] > _REAL * variance:
        phi = room[:N]
        row(p, fluid, x, v, phi)
        if setup[FORCE] > 0.0:
            phi[3] = 0.0
        expected, own = memory[EXPECTED], setup[VARIANCE] + p[C0] ** 2 * variance
        if counted[QUIET] > setup[LEAST]:
            spread = own + expected[2] ** 2 * fluid[DOUBT]
            y = innovate(fluid, lean, expected, y, own, phi)
        else:  # what the filter would go by is not known yet
            spread = own + fluid[DOUBT]
        add(memory[BLOCK], phi, y, 1.0 / spread)
        _count(memory[LEVELS], counted[DUTY])
    return bool(counted[FILLED] >= setup[ROWS_OF_BLOCK])


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


@compiled
def close(
    setup: Array,
    rules: Array,
    prior: Array,
    first: Array,
    room: Array,
    window: Array,
    memory: Array,
) -> None:
    """Put the full block into the window (BLOCKS, SIZE), what leaves it into the lessons, and judge anew, in place."""
    counted, verdict, block = memory[COUNTED], memory[VERDICT], memory[BLOCK]
    ones, total = room[N : 2 * N], room[2 * N : 2 * N + SIZE]
    ones[:] = 1.0
    surprise = misfit(block, ones, memory[EXPECTED]) / max(block[ROWS], 1.0)
    counted[QUIET] += 1.0
    enough = block[ROWS] >= 0.5 * setup[ROWS_OF_BLOCK]
    if (
        enough
        and counted[QUIET] > setup[LEAST]
        and surprise > setup[CUT] * max(verdict[MISFIT], 1.0)
    ):
        _shorten(setup, rules, int(setup[FRESH]), window, memory)
        counted[COUNT], counted[QUIET] = 0.0, -1.0
        memory[LEAN] = 0.0
    elif _well(verdict):
        _shorten(setup, rules, int(setup[CALM]) - 1, window, memory)
    head = int(counted[HEAD])
    if (
        counted[QUIET] > 0.0
    ):  # a cut lies within its block, and the fluid still follows in the next one
        head = (head + 1) % BLOCKS
        window[head] = block
        counted[HEAD], counted[COUNT] = head, min(counted[COUNT] + 1.0, float(BLOCKS))
    block[:] = 0.0
    counted[FILLED] = 0.0
    if counted[COUNT] < setup[LEAST]:
        return
    total[:] = 0.0
    for i in range(int(counted[COUNT])):
        total += window[(head - i) % BLOCKS]
    _conclude(setup, rules, prior, first, room, memory)


@compiled
def _conclude(
    setup: Array, rules: Array, prior: Array, first: Array, room: Array, memory: Array
) -> None:
    """The verdict on the total that lies in the room."""
    total, belief = room[2 * N : 2 * N + SIZE], room[2 * N + SIZE : 2 * N + 2 * SIZE]
    belief[:] = prior + memory[TAUGHT]
    rest, verdict = room[2 * N + 2 * SIZE :], memory[VERDICT]
    memory[LEVELS] *= setup[KEPT]
    verdict[SINGLE] = _single(memory[LEVELS])
    decide(rules, total, belief, first, verdict, rest)
    expected, fluid = memory[EXPECTED], memory[FLUID]
    for i in range(N):
        new = rest[i] * rest[N + i]
        fluid[F_ER] += memory[LEAN][i] * (new - expected[i])
        expected[i] = new
    verdict[RESIDUAL] = math.sqrt(max(verdict[MISFIT] - 1.0, 0.0) * setup[VARIANCE])


@compiled
def _well(verdict: Array) -> bool:
    """Whether the damper is healthy and nothing speaks against it."""
    return (
        int(verdict[KIND]) == NONE and int(verdict[TRIED]) == NONE and verdict[UNEXPLAINED] <= 0.0
    )


@compiled
def _shorten(setup: Array, rules: Array, keep: int, window: Array, memory: Array) -> None:
    """Let all blocks but the newest `keep` leave the window, into the lessons if all is well."""
    counted, verdict, taught = memory[COUNTED], memory[VERDICT], memory[TAUGHT]
    head, count = int(counted[HEAD]), int(counted[COUNT])
    for i in range(keep, count):
        if _well(verdict):
            taught *= setup[KEPT]
            taught += window[(head - i) % BLOCKS] / (
                rules[COLOUR] * max(verdict[MISFIT], LEAST_MISFIT)
            )
    counted[COUNT] = min(count, keep)
