"""One sample of an observer in one compiled call: the state, what it says, and its health.

The memory between samples is one array: health (8,), change (1,), y (m,), pace (m,), x (n,), z (N,), payload (36,).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from er_models.model import Array

from er_observers.observers import payload
from er_observers.observers.compiled import compiled
from er_observers.observers.kernel import HEAD, SUBSTEP, advance
from er_observers.observers.matrices import Plan
from er_observers.observers.payload import RATIO, SPEED, even_drive, learn
from er_observers.observers.watch import (
    DOUBT,
    FLOOR,
    LOST,
    POWER,
    SETTLED,
    contradiction,
    decay_rate,
    follow,
    follows,
    judge,
)

BEND = 0.6
"""Share of the parabola through the last three samples that the outputs follow between two.

Whole, it over-bends what moves at a quarter of the sampling rate; from 0.5 to 0.7 the errors on ISO
roads are the smallest, a tenth to a sixth below those of straight lines.
"""
_PICOSECONDS = 1e12
_KNOWN = payload.SIZE
HEALTH = slice(0, 8)
CHANGE = 8


class Layout(NamedTuple):
    """Where things lie in the memory: outputs m, model states n, observer states N."""

    m: int
    n: int
    order: int

    @property
    def y(self) -> slice:
        """Outputs of the last sample (m,)."""
        return slice(9, 9 + self.m)

    @property
    def pace(self) -> slice:
        """The rate they came with (m,), NaN where it is not known."""
        return slice(9 + self.m, 9 + 2 * self.m)

    @property
    def x(self) -> slice:
        """Estimate of the model's state (n,)."""
        return slice(9 + 2 * self.m, 9 + 2 * self.m + self.n)

    @property
    def z(self) -> slice:
        """The observer's own state (N,)."""
        return slice(9 + 2 * self.m + self.n, 9 + 2 * self.m + self.n + self.order)

    @property
    def payload(self) -> slice:
        """What is known of the sprung mass, see `payload`."""
        return slice(self.z.stop, self.z.stop + payload.SIZE)


@compiled
def bend_of(y_0: Array, y_1: Array, pace: Array, dt: float, out: Array) -> None:
    """Bend (m,) of the outputs over dt [s], from the change of their rate; none where it is not known.

    The whole change would be that of a parabola through three samples.
    """
    for j in range(y_0.shape[0]):
        change = (y_1[j] - y_0[j]) / dt - pace[j]
        out[j] = 0.5 * BEND * dt * change if math.isfinite(change) else 0.0


@compiled
def duty_within(duty: float, before: float, low: float, high: float) -> tuple[float, bool]:
    """Duty within the gains' range, and whether it was repaired; NaN keeps the one before."""
    if not math.isfinite(duty):
        return before, True
    return min(max(duty, low), high), not low - 1e-6 <= duty <= high + 1e-6


def book_of(plan: Plan, reading: Array, rules: Array, mass: Array, layout: Layout) -> Array:
    """All that `run_sample` takes of an observer: where the parts begin, the parts, room for a memory.

    reading: R (n, N), S (n, m), F (n,), Gamma (n,) one after the other; rules: of `watch.rules_of`;
    mass: of `payload.numbers_of`.
    """
    parts = (plan.values, reading, rules, mass, plan.scratch)
    ends = 5.0 + np.cumsum([len(p) for p in parts])
    return np.concatenate([ends, *parts, np.empty(layout.payload.stop)])


@compiled
def run_sample(
    book: Array, memory: Array, sprung: float, unsprung: float, deflection: float, last: float,
    asked: float, dt: float,
) -> tuple[float, float, float, float, int, float, bool, bool]:  # fmt: skip
    """Bring the memory, in place, dt [s] further with the duty `last` in force.

    book: of `book_of`. sprung, unsprung, deflection: outputs, as many as there are. Returns `said`,
    the duty from now on as `duty_within` has it, and whether it went so: a sample that does not
    simply follow the one before changes nothing.
    """
    a, b, c, d, e = int(book[0]), int(book[1]), int(book[2]), int(book[3]), int(book[4])
    values, reading, rules, mass = book[5:a], book[a:b], book[b:c], book[c:d]
    scratch, before = book[d:e], book[e:]
    order, m, table = int(values[0]), int(values[1]), int(values[3])
    last_of_z = memory.shape[0] - _KNOWN
    n, duties = last_of_z - 9 - 2 * m - order, HEAD + 2 * order + m
    if not follows(rules, memory[LOST], dt, sprung, unsprung, deflection, m):
        return 0.0, 0.0, 0.0, 0.0, 0, last, False, False
    for i in range(memory.shape[0]):
        before[i] = memory[i]
    dt = np.round(dt * _PICOSECONDS) / _PICOSECONDS  # stamps are sums of rounded periods
    duty, repaired = duty_within(asked, last, values[duties], values[duties + table - 1])
    y, at = memory[9 : 9 + m], 9 + 2 * m + n
    known = memory[last_of_z:]
    ratio_of_mass, sprung_before = known[RATIO], before[9]
    y[0], y[1] = ratio_of_mass * sprung, unsprung
    before[9] *= ratio_of_mass
    before[9 + m] *= ratio_of_mass
    if m > 2:
        y[2] = deflection
    y_0, bend = before[9 : 9 + m], memory[9 + m : 9 + 2 * m]
    bend_of(y_0, y, before[9 + m : 9 + 2 * m], dt, bend)
    n_sub = max(1, math.ceil(dt / SUBSTEP - 1e-6))
    z, next_z = before[at:last_of_z], memory[at:last_of_z]
    v, past = before[10 + 2 * m], sprung_before - before[10]
    extra = even_drive(mass, known, v, sprung - unsprung, past, dt)
    end = advance(values, scratch, z, y_0, y, bend, last, dt, n_sub, next_z, extra)
    for i in range(n):
        total = 0.0
        for k in range(order):
            total += reading[i * order + k] * memory[at + k]
        for j in range(m):
            total += reading[n * order + i * m + j] * y[j]
        memory[9 + 2 * m + i] = total
    y[0], before[9] = sprung, sprung_before
    if memory[DOUBT] > rules[SETTLED]:
        known[SPEED] = math.nan  # the error of a start without start phase teaches nothing
    learn(mass, known, y_0[0], y_0[1], sprung, unsprung, memory[10 + 2 * m], end, last, dt)
    force, x, v, ratio, verdict = keep(
        reading, rules, before, last, dt, repaired, end, m, n, memory
    )
    return force, x, v, ratio, verdict, duty, repaired, True


@compiled
def keep(
    reading: Array, rules: Array, before: Array, duty: float, dt: float, repaired: bool, end: float,
    m: int, n: int, after: Array,
) -> tuple[float, float, float, float, int]:  # fmt: skip
    """The rest of the memory where y, x and z are known; end: the gate's input. Returns `said`."""
    x = 9 + 2 * m
    relative = before[9] - before[10]
    change = after[9] - after[10] - relative
    correction = after[x + 1] - before[x + 1] - dt * (relative + 0.5 * change)
    for j in range(m):
        after[9 + m + j] = (after[9 + j] - before[9 + j]) / dt
    for j in range(8):
        after[j] = before[j]
    after[CHANGE] = change
    slope = 1.0 - math.tanh(end) ** 2
    rate = decay_rate(rules, duty, slope)
    follow(rules, after[:8], dt, rate, correction, change - before[CHANGE], repaired)
    return said(reading, rules, m, n, after)


@compiled
def said(
    reading: Array, rules: Array, m: int, n: int, memory: Array
) -> tuple[float, float, float, float, int]:
    """Force [N], deflection [m], its velocity [m/s], test ratio, and which of `status.VERDICTS`."""
    x = 9 + 2 * m
    at = reading.shape[0] - 2 * n
    force = 0.0
    for i in range(n):
        force += reading[at + i] * memory[x + i]
    ratio = contradiction(memory[POWER], memory[FLOOR])
    return force, memory[x], memory[x + 1], ratio, judge(rules, memory[:8])
