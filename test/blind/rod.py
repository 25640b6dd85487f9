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
    LEFT,
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
def hydraulic(x: float, v: float, y: Array, rows: Array, base: Array) -> float:
    """Force [N] of the filled damper: viscous terms and the field force."""
    c = base[C0] * self_heating.viscosity(y[TF], rows[HEATING, 0])
    c *= shear_thinning.factor(v, rows[THINNING, 0], rows[THINNING, 1], rows[THINNING, 2])
    total = c * v + y[FER]
    total += quadratic_damping.force(v, rows[QUADRATIC, 0], rows[QUADRATIC, 1])
    total += asymmetric_damping.force(v, rows[ASYMMETRIC, 0], rows[ASYMMETRIC, 1])
    total += position_dependent_damping.force(x, v, rows[POSITION, 0], rows[POSITION, 1])
    total += field.viscous(v, y[FLD], rows[FIELD_VISCOSITY, 0])
    return float(total)


@inner
def friction(v: float, y: Array, rows: Array) -> float:
    """Force [N] of dry friction and pre-sliding."""
    total = coulomb_friction.force(v, rows[COULOMB, 0], rows[COULOMB, 1])
    i, j = STRIBECK, HYSTERESIS
    total += stribeck_friction.force(v, rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3])
    z = y[HYS]
    rate = bouc_wen_hysteresis.rate(
        z, v, rows[j, 0], rows[j, 1], rows[j, 2], rows[j, 3], rows[j, 4]
    )
    total += bouc_wen_hysteresis.force(z, rate, rows[j, 0], rows[j, 1], rows[j, 5])
    return float(total)


@inner
def elastic(x: float, v: float, y: Array, rows: Array, base: Array) -> float:
    """Force [N] of springs, gas, stops and relaxing branches."""
    g, e, m = GAS_SPRING, END_STOP, VISCOELASTIC
    total = base[K0] * x + rows[PRELOAD, 0]
    total += gas_spring.force(x, rows[g, 0], rows[g, 1], rows[g, 2], rows[g, 3])
    total += end_stop.force(x, v, rows[e, 0], rows[e, 1], rows[e, 2])
    total += field.elastic(x, y[FLD], rows[FIELD_STIFFNESS, 0], rows[FIELD_STIFFNESS, 1])
    total += viscoelastic_branch.force(x, y[MX1], y[MX2], rows[m, 0], rows[m, 1])
    return float(total)


@inner
def force(
    x: float, v: float, burst: float, y: Array, memory: Array, rows: Array, base: Array
) -> float:
    """Force of the rod [N] without inertia, positive against extension."""
    h = hydraulic(x, v, y, rows, base)
    h = cavitation.limited(
        h, y[VOID], rows[CAVITATION, 0], rows[CAVITATION, 1], rows[CAVITATION, 2]
    )
    total = h + friction(v, y, rows) + elastic(x, v, y, rows, base)
    total += outside_force.force(x, v, burst, memory, rows)
    return float(total * memory[LEFT])
