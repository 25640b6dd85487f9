"""One sample of an observer in one compiled call: the state, what it says, and its health.

The memory between samples is one array: health (8,), change of the relative acceleration [m/s2], y (m,), pace (m,),
x (n,), z (N,), payload (49,), fusion (70,). `Layout` says where each begins.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from er_models.model import Array

from er_observers.observers import fusion, payload, watch
from er_observers.observers.compiled import compiled
from er_observers.observers.fusion import ADRIFT, REFUSED, TRUST, fuse
from er_observers.observers.kernel import HEAD, SUBSTEP, advance
from er_observers.observers.matrices import Plan
from er_observers.observers.payload import (
    RATIO,
    SPEED,
    UNDECIDED,
    YIELD,
    even_drive,
    learn,
)
from er_observers.observers.pooled import pooled
from er_observers.observers.status import ALONE, BLIND, FINE, REPAIRED, UNTOLD, WRONG
from er_observers.observers.watch import (
    DEFLECTION,
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

BEND, TURN = 1.5, 0.5
"""Share of a parabola that the outputs follow between two samples, and how the rate before it is corrected.

A parabola through the last three samples bends as the outputs did one sample ago. The rate that is expected next is the
last one and `TURN` of what the one expected before it missed: so the bend weighs the last changes of the rate by 1,
-1/2, 1/4, ..., which leads them on. A road has content beyond the sample rate, and half as much again as such a
parabola bends is nearer to it: on ISO roads 0.5 (class E) to 0.93 times (class A) the error of a share of 1.
"""
_PICOSECONDS = 1e12
HEALTH = slice(0, watch.SIZE)
CHANGE = watch.SIZE
HEAD_SIZE = CHANGE + 1
"""Numbers before the outputs."""
_PARTS = 6
"""Parts of a book; it begins with their ends."""


class Layout(NamedTuple):
    """Where things lie in the memory: outputs m, model states n, observer states N; of `layout_of`.

    *_at: where y, pace, x, z, the payload and the fusion begin; size: numbers in the memory.
    """

    m: int
    n: int
    order: int
    y_at: int
    pace_at: int
    x_at: int
    z_at: int
    payload_at: int
    fusion_at: int
    size: int

    @property
    def y(self) -> slice:
        """Outputs of the last sample (m,)."""
        return slice(self.y_at, self.pace_at)

    @property
    def pace(self) -> slice:
        """The rate that they are expected to go on with (m,), NaN where it is not known."""
        return slice(self.pace_at, self.x_at)

    @property
    def x(self) -> slice:
        """Estimate of the model's state (n,)."""
        return slice(self.x_at, self.z_at)

    @property
    def z(self) -> slice:
        """The observer's own state (N,)."""
        return slice(self.z_at, self.payload_at)

    @property
    def payload(self) -> slice:
        """What is known of the sprung mass, see `payload`."""
        return slice(self.payload_at, self.fusion_at)

    @property
    def fusion(self) -> slice:
        """What is known with a deflection sensor, see `fusion`."""
        return slice(self.fusion_at, self.size)


@compiled
def layout_of(m: int, n: int, order: int) -> Layout:
    """Where things lie for m outputs, n model states and N = order observer states."""
    pace = HEAD_SIZE + m
    x = pace + m
    z = x + n
    known = z + order
    fused = known + payload.SIZE
    return Layout(m, n, order, HEAD_SIZE, pace, x, z, known, fused, fused + fusion.SIZE)


@compiled
def bend_of(y_0: Array, y_1: Array, pace: Array, dt: float, out: Array) -> None:
    """Bend (m,) of the outputs over dt [s], from what their rate was expected to be; none where it is not known."""
    for j in range(y_0.shape[0]):
        change = (y_1[j] - y_0[j]) / dt - pace[j]
        out[j] = 0.5 * BEND * dt * change if math.isfinite(change) else 0.0


@compiled
def duty_within(duty: float, before: float, low: float, high: float) -> tuple[float, bool]:
    """Duty within the gains' range, and whether it was repaired; NaN keeps the one before."""
    if not math.isfinite(duty):
        return before, True
    return min(max(duty, low), high), not low - 1e-6 <= duty <= high + 1e-6


def book_of(
    plan: Plan, reading: Array, rules: Array, mass: Array, sensors: Array, layout: Layout
) -> Array:
    """All that `run_sample` takes of an observer: where the parts begin, the parts, room for a memory.

    reading: R (n, N), S (n, m), F (n,), Gamma (n,) one after the other; rules: of `watch.rules_of`;
    mass: of `payload.numbers_of`; sensors: of `fusion.numbers_of`.
    """
    parts = (plan.values, reading, rules, mass, sensors, plan.scratch)
    ends = float(_PARTS) + np.cumsum([len(p) for p in parts])
    return np.concatenate([ends, *parts, np.empty(layout.size)])


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
    a, b, c, d = int(book[0]), int(book[1]), int(book[2]), int(book[3])
    values, reading, rules, mass = book[_PARTS:a], book[a:b], book[b:c], book[c:d]
    d, e, g = int(book[3]), int(book[4]), int(book[5])
    sensors, scratch, before = book[d:e], book[e:g], book[g:]
    order, m, duties = int(values[0]), int(values[1]), int(values[3])
    lay = layout_of(m, memory.shape[0] - layout_of(m, 0, order).size, order)
    if not follows(rules, memory[LOST], dt, sprung, unsprung, deflection, m):
        return 0.0, 0.0, 0.0, 0.0, 0, last, False, False
    for i in range(memory.shape[0]):
        before[i] = memory[i]
    dt = np.round(dt * _PICOSECONDS) / _PICOSECONDS  # stamps are sums of rounded periods
    lowest = HEAD + 2 * order + m
    duty, repaired = duty_within(asked, last, values[lowest], values[lowest + duties - 1])
    y, pace, x, z, known = lay.y_at, lay.pace_at, lay.x_at, lay.z_at, lay.payload_at
    y_0, y_1, bend, mass_known = (
        before[y:pace],
        memory[y:pace],
        memory[pace:x],
        memory[known : lay.fusion_at],
    )
    ratio_of_mass, sprung_before = mass_known[RATIO], y_0[0]
    y_1[0], y_1[1] = ratio_of_mass * sprung, unsprung
    if m > 2:
        y_1[2] = deflection
    y_0[0] *= ratio_of_mass
    before[pace] *= ratio_of_mass
    bend_of(y_0, y_1, before[pace:x], dt, bend)
    n_sub = max(1, math.ceil(dt / SUBSTEP - 1e-6))
    past = sprung_before - y_0[1]
    extra = even_drive(mass, mass_known, before[x + 1], sprung - unsprung, past, dt)
    z_0, z_1 = before[z:known], memory[z:known]
    end = advance(values, scratch, z_0, y_0, y_1, bend, last, dt, n_sub, z_1, extra)
    _read(reading, z_1, y_1, memory[x:z])
    y_1[0], y_0[0] = sprung, sprung_before
    before[pace] /= ratio_of_mass
    if memory[DOUBT] > rules[SETTLED]:
        mass_known[SPEED] = math.nan  # the error of a start without start phase teaches nothing
    v, f = memory[x + 1], memory[x + int(mass[YIELD])]
    learn(mass, mass_known, y_0[0], y_0[1], sprung, unsprung, v, end, f, last, dt)
    said = keep(reading, rules, before, last, dt, repaired, end, lay, memory)
    fused = memory[lay.fusion_at :]
    seen = deflection if abs(deflection) <= rules[DEFLECTION] else math.nan
    found = fuse(sensors, fused, sprung, unsprung, seen, memory[x:z], last, dt)
    alone = said[0] if said[4] == FINE else math.nan
    found = pooled(sensors, fused, found, alone, sprung, seen, dt)
    force, x_1, v_1, ratio, verdict = better(said, found, fused)
    return force, x_1, v_1, ratio, verdict, duty, repaired, True


@compiled
def better(
    said: tuple[float, float, float, float, int],
    found: tuple[bool, float, float, float],
    fused: Array,
) -> tuple[float, float, float, float, int]:
    """What is `said` with a deflection sensor: what was `found` with it, or that it is refused."""
    force, x, v, ratio, verdict = said
    believed, fused_force, fused_x, fused_v = found
    if believed:
        good = WRONG if fused[ADRIFT] > 0.0 else FINE
        return fused_force, fused_x, fused_v, ratio, REPAIRED if verdict == REPAIRED else good
    if verdict == FINE and fused[TRUST] == REFUSED:
        verdict = ALONE
    return force, x, v, ratio, verdict


@compiled
def _read(reading: Array, z: Array, y: Array, x: Array) -> None:
    """Fill the estimate x (n,) = R z + S y; reading: of `book_of`, z (N,), y (m,)."""
    n, order, m = x.shape[0], z.shape[0], y.shape[0]
    for i in range(n):
        total = 0.0
        for k in range(order):
            total += reading[i * order + k] * z[k]
        for j in range(m):
            total += reading[n * order + i * m + j] * y[j]
        x[i] = total


@compiled
def keep(
    reading: Array, rules: Array, before: Array, duty: float, dt: float, repaired: bool, end: float,
    lay: Layout, after: Array,
) -> tuple[float, float, float, float, int]:  # fmt: skip
    """The rest of the memory where y, x and z are known; end: the gate's input. Returns `said`."""
    y, v = lay.y_at, lay.x_at + 1
    relative = before[y] - before[y + 1]
    change = after[y] - after[y + 1] - relative
    correction = after[v] - before[v] - dt * (relative + 0.5 * change)
    for j in range(lay.m):
        rate, expected = (after[y + j] - before[y + j]) / dt, before[lay.pace_at + j]
        missed = rate - expected if math.isfinite(expected) else 0.0
        after[lay.pace_at + j] = rate + TURN * missed
    for j in range(watch.SIZE):
        after[j] = before[j]
    after[CHANGE] = change
    slope = 1.0 - math.tanh(end) ** 2
    rate = decay_rate(rules, duty, slope)
    follow(rules, after[HEALTH], dt, rate, correction, change - before[CHANGE], repaired)
    return said(reading, rules, lay, after)


@compiled
def said(
    reading: Array, rules: Array, lay: Layout, memory: Array
) -> tuple[float, float, float, float, int]:
    """Force [N], deflection [m], its velocity [m/s], test ratio, and which of `status.VERDICTS`."""
    n, x = lay.n, lay.x_at
    at = reading.shape[0] - 2 * n
    force = 0.0
    for i in range(n):
        force += reading[at + i] * memory[x + i]
    ratio = contradiction(memory[POWER], memory[FLOOR])
    verdict = judge(rules, memory[HEALTH])
    if verdict in (FINE, BLIND) and memory[lay.payload_at + UNDECIDED] > 0.0:
        verdict = UNTOLD
    return force, memory[x], memory[x + 1], ratio, verdict
