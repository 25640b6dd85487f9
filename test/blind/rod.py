"""Force of the damper's rod from its own travel and velocity: the base and all force effects.

Base, thesis (1.12): F = k0 x + c0 v + F_er, tau F_er' + F_er = fc u tanh(k1 x + c1 v).
"""

from __future__ import annotations

from test.blind.catalogue import EVERY
from test.blind.jit import Array, inner
from test.blind.places import composed
from test.blind.slots import (
    C0,
    CAVITATION,
    FER,
    HEATING,
    K0,
    MX1,
    MX2,
    PRELOAD,
    TF,
    VISCOELASTIC,
    VOID,
)
from test.blind.truth import cavitation, outside_force, self_heating, viscoelastic_branch

viscosity, fluid, bypass, friction, elastic, whole = (
    composed(place, EVERY)
    for place in ("viscosity", "fluid", "bypass", "friction", "elastic", "whole")
)


@inner
def hydraulic(
    t: float, x: float, v: float, y: Array, dy: Array, rows: Array, base: Array
) -> float:
    """Force [N] of the filled damper: viscous terms and the field force."""
    c = base[C0] * self_heating.viscosity(y[TF], rows[HEATING, 0])
    c = viscosity(c, t, x, v, y, dy, rows)
    carried = fluid(c * v + y[FER], t, x, v, y, dy, rows)
    return float(bypass(carried, t, x, v, y, dy, rows))


@inner
def springs(t: float, x: float, v: float, y: Array, dy: Array, rows: Array, base: Array) -> float:
    """Force [N] of springs, gas, stops and relaxing branches."""
    m = VISCOELASTIC
    total = elastic(base[K0] * x + rows[PRELOAD, 0], t, x, v, y, dy, rows)
    total += viscoelastic_branch.force(x, y[MX1], y[MX2], rows[m, 0], rows[m, 1])
    return float(total)


@inner
def force(
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
    """Force of the rod [N] without inertia, positive against extension."""
    h = hydraulic(t, x, v, y, dy, rows, base)
    h = cavitation.limited(
        h, y[VOID], rows[CAVITATION, 0], rows[CAVITATION, 1], rows[CAVITATION, 2]
    )
    total = h + friction(0.0, t, x, v, y, dy, rows) + springs(t, x, v, y, dy, rows, base)
    total += outside_force.force(x, v, burst, memory, rows)
    return float(whole(total, t, x, v, y, dy, rows))
