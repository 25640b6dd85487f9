r"""Car and damper between two samples, and what every unknown changes in it, compiled.

.. math::  \dot x = v, \quad \dot v = -\mu f - w, \quad \tau \dot F_{er} = \sigma u^\beta \tanh(k_1 x + c_1 v) - F_{er},
           \quad \dot w = \tfrac{k_t}{m_{us}} (v + r), \quad \dot r = f / m_s + a

with f = k_s x + F_d + b of (2.1) and (6.8), 1 / mu the mass of both bodies against one another, w the acceleration that
the tyre gives the wheel, r the rate of the road less that of the body, and a the slope of the road's rate. Under a
field a damper that does not yield is a spring on which the wheel swings some hundred times a second: no curve through
two samples shows that, but these equations do. A piece is an implicit midpoint step; the gate acts with its mean along
the piece and the field with the mean of its own answer, so the one unknown is where the gate ends, and no response time
is too short.

Source: thesis (2.1), (2.10), (6.8); Quispel and McLaren 2008 (average vector field).
"""

from __future__ import annotations

import math

from er_models.model import Array

from er_observers.faults.regression import BETA, C0, C1, K0, K1, K_S, K_T, M_S, M_US, SIGMA, TAU
from er_observers.observers.compiled import compiled
from er_observers.observers.gate import gate_of, slopes_of, solve_gate

X, V, F_ER, W, R = range(5)
"""Places in the state (5,)."""
STATES = 5
RAMP = 5
"""Place of the slope of the road's rate in the derivatives, behind the state; then come the unknowns."""
COLUMNS = RAMP + 1
"""Columns of the derivatives before those of the unknowns."""
LONGEST, PIECES = 0.3125e-3, 16
"""Longest piece of a sample [s], and the most pieces of one: as many as a sample of 200 Hz has."""
(
    STIFF, VISCOUS, FIELD, OFFSET, LAG, BY_X, BY_V, PER_MASS, BODY, PUSH, TYRE, HEIGHT, KEPT, MEAN, PIECE, HALF, COUNT,
    SLOPE,
) = range(18)  # fmt: skip
"""Places in the law (18,): f = STIFF x + VISCOUS v + FIELD F_er + OFFSET; response time and gate; mu, what a force
gives the body, what the body has besides; tyre over wheel; height of the gate; what a piece leaves of F_er, and the
share of it that acts in the mean; length of a piece; what half a piece takes from v; number of pieces; slope of the
road's rate [m/s2]."""
LAW = 18
TURNED = 7
"""Columns of `turn` (N, 7): derivatives of the law's first seven places by the unknowns."""
_LEAST = 0.02
"""Least share of the field that errors of the gate are counted in."""


@compiled
def prescribe(
    p: Array, known: Array, duty: float, dt: float, push: float, law: Array, turn: Array
) -> None:
    """Fill the law for unknowns (N,) that are believed, a duty and a sample of dt [s].

    push: acceleration of the body [m/s2] where its sensor tells it, NaN where f does.
    """
    share = max(known[2], _LEAST)
    law[STIFF] = p[K_S] * (1.0 + known[3]) + p[K0] * known[0]
    law[VISCOUS], law[FIELD], law[OFFSET] = p[C0] * known[1], known[2], known[4]
    law[LAG] = p[TAU] * max(1.0 + known[5] / share, 0.2)
    law[BY_X], law[BY_V] = (
        p[K1] * (1.0 + known[6] / share),
        p[C1] * max(1.0 + known[7] / share, 0.2),
    )
    told = math.isfinite(push)
    law[BODY], law[PUSH] = (0.0, push) if told else (1.0 / p[M_S], 0.0)
    law[SLOPE] = 0.0
    law[PER_MASS] = law[BODY] + 1.0 / p[M_US]
    law[TYRE] = p[K_T] / p[M_US]
    law[HEIGHT] = p[SIGMA] * duty ** p[BETA] if duty > 0.0 else 0.0
    law[COUNT] = min(max(math.ceil(dt / LONGEST), 1), PIECES)
    h = dt / law[COUNT]
    law[PIECE], law[KEPT], law[MEAN] = h, 0.0, 0.0
    if p[TAU] > 0.0:
        law[KEPT] = math.exp(-h / law[LAG])
        law[MEAN] = (1.0 - law[KEPT]) * law[LAG] / h
    law[HALF] = _half(law, law[STIFF], law[VISCOUS]) + 0.25 * h * h * law[TYRE]
    turn[:] = 0.0
    turn[0, STIFF], turn[3, STIFF] = p[K0], p[K_S]
    turn[1, VISCOUS], turn[2, FIELD], turn[4, OFFSET] = p[C0], 1.0, 1.0
    turn[5, LAG], turn[6, BY_X], turn[7, BY_V] = p[TAU] / share, p[K1] / share, p[C1] / share


@compiled
def _half(law: Array, stiff: float, viscous: float) -> float:
    """What stiffness and viscosity take from v within half a piece."""
    h = law[PIECE]
    return float(h * law[PER_MASS] * (0.25 * h * stiff + 0.5 * viscous))


@compiled
def strut(law: Array, z: Array) -> float:
    """F [N]: what damper and spring take from the body."""
    return float(law[STIFF] * z[X] + law[VISCOUS] * z[V] + law[FIELD] * z[F_ER] + law[OFFSET])


@compiled
def sample(law: Array, turn: Array, z: Array, T: Array, columns: int) -> None:
    """Bring the state z (5,) over a sample, and the first columns of its derivatives T (5, 6 + N), in place.

    T: by the state at the begin of the sample, by the slope of the road's rate, then by the unknowns.
    """
    for _ in range(int(law[COUNT])):
        _piece(law, turn, z, T, columns)


@compiled
def _piece(law: Array, turn: Array, z: Array, T: Array, columns: int) -> None:
    """One piece of `sample`."""
    h, mass, half, mean = law[PIECE], law[PER_MASS], law[HALF], law[MEAN]
    x, v, force, w, r = z[X], z[V], z[F_ER], z[W], z[R]
    f = strut(law, z)
    rate = r + 0.5 * h * (law[BODY] * f - law[PUSH] + law[SLOPE])
    base = v * (1.0 - half) - h * (w + 0.5 * h * law[TYRE] * rate - law[PUSH])
    base -= h * mass * (law[STIFF] * x + law[OFFSET] + law[FIELD] * mean * force)
    pull = h * mass * law[FIELD] * (1.0 - mean) * law[HEIGHT]
    lean, whole = law[BY_V] + 0.5 * h * law[BY_X], 1.0 + half
    s_0 = law[BY_X] * x + law[BY_V] * v
    t_0, area = gate_of(s_0)
    free = law[BY_X] * (x + 0.5 * h * v) + lean * base / whole
    s_1, t_1, _, gate = solve_gate(s_0, t_0, area, free, -lean * pull / whole)
    v_1 = (base - pull * gate) / whole
    x_1 = x + 0.5 * h * (v + v_1)
    early, late = slopes_of(s_0, t_0, s_1, t_1, gate)
    z[X], z[V], z[R] = x_1, v_1, r + h * (law[BODY] * f - law[PUSH] + law[SLOPE])
    z[F_ER] = law[KEPT] * force + (1.0 - law[KEPT]) * law[HEIGHT] * gate
    z[W] = w + h * law[TYRE] * (0.5 * (v + v_1) + rate)
    for j in range(columns):
        dx, dv, df, dw, dr = T[X, j], T[V, j], T[F_ER, j], T[W, j], T[R, j]
        d_f = law[STIFF] * dx + law[VISCOUS] * dv + law[FIELD] * df
        d_mean = d_kept = d_half = d_stiff = d_field = d_offset = d_x = d_v = 0.0
        d_slope = 1.0 if j == RAMP else 0.0
        if j >= COLUMNS:
            i = j - COLUMNS
            d_stiff, d_field, d_offset = turn[i, STIFF], turn[i, FIELD], turn[i, OFFSET]
            d_x, d_v = turn[i, BY_X], turn[i, BY_V]
            d_half = _half(law, d_stiff, turn[i, VISCOUS])
            d_f += d_stiff * x + turn[i, VISCOUS] * v + d_field * force + d_offset
            if turn[i, LAG] > 0.0:
                d_kept = law[KEPT] * h / law[LAG] ** 2 * turn[i, LAG]
                d_mean = (1.0 - law[KEPT]) / h * turn[i, LAG] - d_kept * law[LAG] / h
        d_rate = dr + 0.5 * h * (law[BODY] * d_f + d_slope)
        d_base = dv * (1.0 - half) - v * d_half - h * (dw + 0.5 * h * law[TYRE] * d_rate)
        d_base -= h * mass * (
            d_stiff * x + law[STIFF] * dx + d_offset + law[FIELD] * mean * df
            + (d_field * mean + law[FIELD] * d_mean) * force
        )  # fmt: skip
        d_pull = h * mass * law[HEIGHT] * (d_field * (1.0 - mean) - law[FIELD] * d_mean)
        d_0 = law[BY_X] * dx + law[BY_V] * dv + d_x * x + d_v * v
        bare = law[BY_X] * (dx + 0.5 * h * dv) + d_x * x_1 + d_v * v_1
        dv_1 = d_base - d_pull * gate - v_1 * d_half - pull * (early * d_0 + late * bare)
        dv_1 /= whole + pull * late * lean
        d_gate = early * d_0 + late * (bare + lean * dv_1)
        T[X, j], T[V, j], T[R, j] = (
            dx + 0.5 * h * (dv + dv_1),
            dv_1,
            dr + h * (law[BODY] * d_f + d_slope),
        )
        T[F_ER, j] = law[KEPT] * df + d_kept * (force - law[HEIGHT] * gate)
        T[F_ER, j] += (1.0 - law[KEPT]) * law[HEIGHT] * d_gate
        T[W, j] = dw + h * law[TYRE] * (0.5 * (dv + dv_1) + d_rate)
