"""Force of the damper's rod from its own travel and velocity: the base and all force effects.

Base, thesis (1.12): F = k0 x + c0 v + F_er, tau F_er' + F_er = fc u tanh(k1 x + c1 v).
"""

from __future__ import annotations

from test.blind.jit import Array, inner
from test.blind.slots import (
    ASYMMETRIC,
    C0,
    CAVITATION,
    COULOMB,
    END_STOP,
    FER,
    FIELD_STIFFNESS,
    FIELD_VISCOSITY,
    FLD,
    GAS_SPRING,
    HEATING,
    HYS,
    HYSTERESIS,
    K0,
    MX1,
    MX2,
    POSITION,
    PRELOAD,
    QUADRATIC,
    STRIBECK,
    TF,
    THINNING,
    VISCOELASTIC,
    VOID,
)
from test.blind.truth import (
    asymmetric_damping,
    bouc_wen_hysteresis,
    cavitation,
    coulomb_friction,
    end_stop,
    field,
    gas_spring,
    outside_force,
    position_dependent_damping,
    quadratic_damping,
    self_heating,
    shear_thinning,
    stribeck_friction,
    viscoelastic_branch,
)


@inner
def hydraulic(x: float, v: float, y: Array, P: Array, base: Array) -> float:
    """Force [N] of the filled damper: viscous terms and the field force."""
    c = base[C0] * self_heating.viscosity(y[TF], P[HEATING, 0])
    c *= shear_thinning.factor(v, P[THINNING, 0], P[THINNING, 1], P[THINNING, 2])
    total = c * v + y[FER]
    total += quadratic_damping.force(v, P[QUADRATIC, 0], P[QUADRATIC, 1])
    total += asymmetric_damping.force(v, P[ASYMMETRIC, 0], P[ASYMMETRIC, 1])
    total += position_dependent_damping.force(x, v, P[POSITION, 0], P[POSITION, 1])
    total += field.viscous(v, y[FLD], P[FIELD_VISCOSITY, 0])
    return float(total)


@inner
def friction(v: float, y: Array, P: Array) -> float:
    """Force [N] of dry friction and pre-sliding."""
    total = coulomb_friction.force(v, P[COULOMB, 0], P[COULOMB, 1])
    i, j = STRIBECK, HYSTERESIS
    total += stribeck_friction.force(v, P[i, 0], P[i, 1], P[i, 2], P[i, 3])
    z = y[HYS]
    rate = bouc_wen_hysteresis.rate(z, v, P[j, 0], P[j, 1], P[j, 2], P[j, 3], P[j, 4])
    total += bouc_wen_hysteresis.force(z, rate, P[j, 0], P[j, 1], P[j, 5])
    return float(total)


@inner
def elastic(x: float, v: float, y: Array, P: Array, base: Array) -> float:
    """Force [N] of springs, gas, stops and relaxing branches."""
    g, e, m = GAS_SPRING, END_STOP, VISCOELASTIC
    total = base[K0] * x + P[PRELOAD, 0]
    total += gas_spring.force(x, P[g, 0], P[g, 1], P[g, 2], P[g, 3])
    total += end_stop.force(x, v, P[e, 0], P[e, 1], P[e, 2])
    total += field.elastic(x, y[FLD], P[FIELD_STIFFNESS, 0], P[FIELD_STIFFNESS, 1])
    total += viscoelastic_branch.force(x, y[MX1], y[MX2], P[m, 0], P[m, 1])
    return float(total)


@inner
def force(
    x: float, v: float, burst: float, y: Array, memory: Array, P: Array, base: Array
) -> float:
    """Force of the rod [N] without inertia, positive against extension."""
    h = hydraulic(x, v, y, P, base)
    h = cavitation.limited(h, y[VOID], P[CAVITATION, 0], P[CAVITATION, 1], P[CAVITATION, 2])
    total = h + friction(v, y, P) + elastic(x, v, y, P, base)
    return float(total + outside_force.force(x, v, burst, memory, P))
