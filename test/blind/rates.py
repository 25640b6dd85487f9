"""Rates of all states: car or imposed motion, joint, field force, and the states of effects."""

from __future__ import annotations

import math

from test.blind import rod
from test.blind.catalogue import EVERY
from test.blind.jit import Array, inner
from test.blind.places import composed
from test.blind.slots import (
    AM1,
    AM2,
    AMPLIFIER,
    C0,
    C1,
    CAVITATION,
    FC,
    FER,
    FLD,
    HEATING,
    INERTIA,
    K1,
    KS,
    MU,
    MX1,
    MX2,
    TAU,
    TF,
    TW,
    TYR,
    VD,
    VISCOELASTIC,
    VOID,
    VS,
    VU,
    XD,
    ZS,
    ZU,
)
from test.blind.truth import (
    actuation,
    cavitation,
    joint,
    response,
    self_heating,
    suspension,
    tyre,
)

field, yield_force, own_rates = (composed(p, EVERY) for p in ("field", "yield_force", "rate"))


@inner
def _imbalance(
    t: float,
    speed: float,
    x: float,
    v: float,
    burst: float,
    y: Array,
    dy: Array,
    memory: Array,
    rows: Array,
    base: Array,
) -> float:
    """Rod force less joint force [N] if the damper moves at ``speed`` while the car moves at v."""
    rod_force = rod.force(t, y[XD], speed, burst, y, dy, memory, rows, base)
    return rod_force - joint.force(x - y[XD], v - speed, rows)


@inner
def joint_velocity(
    t: float,
    x: float,
    v: float,
    burst: float,
    y: Array,
    dy: Array,
    memory: Array,
    rows: Array,
    base: Array,
) -> float:
    """Velocity [m/s] at which rod and joint carry one force: bracketed regula falsi (Illinois)."""
    low, high = v, v
    at_low = _imbalance(t, low, x, v, burst, y, dy, memory, rows, base)
    at_high = at_low
    step = -at_low / base[C0] * 1.05
    for _ in range(12):
        if abs(at_high) < 1e-9:
            return float(high)
        high = low + step
        at_high = _imbalance(t, high, x, v, burst, y, dy, memory, rows, base)
        if at_high * at_low <= 0.0:
            break
        low, at_low = high, at_high
    for _ in range(40):
        middle = high - at_high * (high - low) / (at_high - at_low)
        at = _imbalance(t, middle, x, v, burst, y, dy, memory, rows, base)
        if abs(at) < 1e-9:
            return float(middle)
        if at * at_high < 0.0:
            low, at_low = high, at_high
        else:
            at_low *= 0.5
        high, at_high = middle, at
    return float(high)


@inner
def field_rates(
    t: float, x: float, v: float, u: float, y: Array, dy: Array, rows: Array, base: Array
) -> None:
    """Amplifier, field and yield force from the duty u that has reached the amplifier."""
    lag = rows[AMPLIFIER, 0]
    if lag != 0.0:
        dy[AM1] = (u - y[AM1]) / lag
        dy[AM2] = (y[AM1] - y[AM2]) / (0.15 * lag)
        u = y[AM2]
    h = field(actuation.beyond_dead_band(u, rows), t, x, v, y, dy, rows)
    dy[FLD] = (h - y[FLD]) / base[TAU]
    level = yield_force(base[FC] * h, t, x, v, y, dy, rows)
    level *= self_heating.yield_force(y[TF], rows[HEATING, 0], rows[HEATING, 1], rows[HEATING, 6])
    target = level * math.tanh(base[K1] * x + base[C1] * v)
    tau = response.time_constant(base[TAU], u, y[FER], target, rows)
    dy[FER] = (target - y[FER]) / tau


@inner
def inner_rates(
    t: float, x: float, v: float, u: float, y: Array, dy: Array, rows: Array, base: Array
) -> None:
    """States of effects that ride on the rod's travel: those of single truths, branches, void, heat."""
    own_rates(u, t, x, v, y, dy, rows)
    if rows[VISCOELASTIC, 0] != 0.0:
        dy[MX1] = (x - y[MX1]) / rows[VISCOELASTIC, 2]
        dy[MX2] = 4.0 * (x - y[MX2]) / rows[VISCOELASTIC, 2]
    if rows[CAVITATION, 0] == 0.0 and rows[HEATING, 0] == 0.0:
        return
    filled = rod.hydraulic(t, x, v, y, dy, rows, base)
    dy[VOID] = cavitation.rate(filled, y[VOID], base[C0], rows[CAVITATION, 0], rows[CAVITATION, 1])
    if rows[HEATING, 0] != 0.0:
        power = max(filled * v, 0.0) if t >= 0.0 else 0.0
        flow = rows[HEATING, 3] * (y[TF] - y[TW])
        dy[TF] = (power - flow) / rows[HEATING, 2]
        dy[TW] = (flow - rows[HEATING, 5] * y[TW]) / rows[HEATING, 4]


@inner
def damper(
    t: float,
    x: float,
    v: float,
    u: float,
    burst: float,
    y: Array,
    dy: Array,
    memory: Array,
    rows: Array,
    base: Array,
) -> float:
    """Force at the joint [N] without outer inertia; fills the rates of the damper's states."""
    if not joint.present(rows):
        field_rates(t, x, v, u, y, dy, rows, base)
        inner_rates(t, x, v, u, y, dy, rows, base)
        return rod.force(t, x, v, burst, y, dy, memory, rows, base)
    mass = rows[INERTIA, 0]
    speed = y[VD] if mass != 0.0 else joint_velocity(t, x, v, burst, y, dy, memory, rows, base)
    pull = joint.force(x - y[XD], v - speed, rows)
    if mass != 0.0:
        dy[VD] = (pull - rod.force(t, y[XD], speed, burst, y, dy, memory, rows, base)) / mass
    dy[XD] = speed
    field_rates(t, y[XD], speed, u, y, dy, rows, base)
    inner_rates(t, y[XD], speed, u, y, dy, rows, base)
    return pull


@inner
def car(force: float, road: float, y: Array, dy: Array, rows: Array, masses: Array) -> float:
    """Fill the car's rates, thesis (2.5); returns the damper force with outer inertia [N]."""
    mass = 0.0 if joint.present(rows) else rows[INERTIA, 0]
    x, z, m_s = y[ZS] - y[ZU], y[ZU] - road, suspension.body(rows, masses)
    spring = masses[KS] * x + suspension.beside(x, y[VS] - y[VU], rows, masses)
    contact = tyre.force(z, y[TYR], rows, masses)
    mobility = 1.0 / m_s + 1.0 / masses[MU]
    free = -(spring + force) * mobility + contact / masses[MU]
    total = force + mass * free / (1.0 + mass * mobility)
    dy[ZS], dy[ZU], dy[TYR] = y[VS], y[VU], tyre.rate(z, y[TYR], rows)
    dy[VS] = -(spring + total) / m_s
    dy[VU] = (spring + total - contact) / masses[MU]
    return float(total)
