r"""Deflection and its velocity from the deflection sensor and the difference of both accelerations, a few samples late.

.. math::  x^- = x + h v + \tfrac{h^2}{6} (2 a_0 + a_1), \quad v^- = v + \tfrac{h}{2} (a_0 + a_1)

with a = z_s'' - z_us'': a Kalman filter, corrected by the measured x and, where there is one, v. How wrong the straight
line between two accelerations may be shows in how much it bends there, so the filter trusts it on a smooth road and
not where the gate or the wheel moves fast. A fault may be told late, so a smoother looks `LAG` samples ahead.

Without the deflection sensor no filter would do: with an unknown lost force (2.19) has a double zero at s = 0, x and v.

Source: thesis (2.19); Kalman 1960; Rauch, Tung and Striebel 1965.
"""

from __future__ import annotations

import math

from er_models.model import Array

from er_observers.observers.compiled import compiled

LAG = 4
"""Samples the smoother looks ahead."""
(
    X, V, P_XX, P_XV, P_VV, X_P, V_P, PP_XX, PP_XV, PP_VV, A_SPRUNG, A_RELATIVE, A_BEFORE, DUTY, GIVEN, DT, GOOD,
) = range(17)  # fmt: skip
"""Columns of the trail: filtered state and covariance, predicted ones, what else was measured, whether x was."""
COLUMNS = 17
_BEND = 0.2
_CURVE = 0.1


@compiled
def begin(noise: Array, x: float, v: float, known: bool, trail: Array) -> None:
    """Start the trail (LAG + 1, COLUMNS) with a first x and v; noise (3,): sd of acceleration, x and v."""
    trail[:] = 0.0
    trail[:, X] = x
    trail[:, V] = v
    trail[:, P_XX] = trail[:, PP_XX] = noise[1] ** 2
    trail[:, P_VV] = trail[:, PP_VV] = noise[2] ** 2 if known else 1e6 * noise[2] ** 2


@compiled
def push(noise: Array, trail: Array, a_relative: float, x: float, v: float, dt: float) -> None:
    """Filter one sample, dt [s] later, into the last row of the trail; x, v: NaN where not measured."""
    for i in range(LAG):
        trail[i] = trail[i + 1]
    old, now = trail[LAG - 1], trail[LAG]
    a_0, a_1 = old[A_RELATIVE], a_relative
    bend = abs(a_1 - 2.0 * a_0 + trail[LAG - 2, A_RELATIVE])
    before = abs(a_0 - 2.0 * trail[LAG - 2, A_RELATIVE] + trail[LAG - 3, A_RELATIVE])
    q = 2.0 * noise[0] ** 2 + (_BEND * max(bend, before)) ** 2
    now[X_P] = old[X] + dt * old[V] + dt * dt / 6.0 * (2.0 * a_0 + a_1)
    now[V_P] = old[V] + 0.5 * dt * (a_0 + a_1)
    now[PP_XX] = old[P_XX] + 2.0 * dt * old[P_XV] + dt * dt * old[P_VV] + 0.25 * q * dt**4
    now[PP_XV] = old[P_XV] + dt * old[P_VV] + 0.5 * q * dt**3
    now[PP_VV] = old[P_VV] + q * dt * dt
    now[X], now[V] = now[X_P], now[V_P]
    now[P_XX], now[P_XV], now[P_VV] = now[PP_XX], now[PP_XV], now[PP_VV]
    now[A_BEFORE], now[A_RELATIVE], now[DT] = a_0, a_relative, dt
    now[GOOD] = 1.0 if math.isfinite(x) else 0.0
    if math.isfinite(x):
        _correct(now, 0, x, noise[1])
    if math.isfinite(v):
        _correct(now, 1, v, noise[2])


@compiled
def _correct(now: Array, which: int, seen: float, deviation: float) -> None:
    """Kalman correction of a row of the trail by x (0) or v (1)."""
    own = now[P_XX] if which == 0 else now[P_VV]
    spread = own + deviation**2
    k_x = (now[P_XX] if which == 0 else now[P_XV]) / spread
    k_v = (now[P_XV] if which == 0 else now[P_VV]) / spread
    error = seen - now[X + which]
    now[X] += k_x * error
    now[V] += k_v * error
    xx, xv, vv = now[P_XX], now[P_XV], now[P_VV]
    row_x, row_v = (xx, xv) if which == 0 else (xv, vv)
    now[P_XX], now[P_XV], now[P_VV] = xx - k_x * row_x, xv - k_x * row_v, vv - k_v * row_v


@compiled
def between(trail: Array) -> float:
    """Variance of the velocity [m2/s2] that the curve before the first row of the trail misses between its ends."""
    a, dt = trail[0, A_RELATIVE], trail[0, DT]
    bend = abs(trail[1, A_RELATIVE] - 2.0 * a + trail[0, A_BEFORE])
    return float((_CURVE * bend * dt) ** 2)


@compiled
def smoothed(trail: Array) -> tuple[float, float, float]:
    """x, v and the variance of v in the first row of the trail, given all later ones."""
    x, v, p_xx, p_xv, p_vv = (
        trail[LAG, 0],
        trail[LAG, 1],
        trail[LAG, 2],
        trail[LAG, 3],
        trail[LAG, 4],
    )
    for k in range(LAG - 1, -1, -1):
        row, later = trail[k], trail[k + 1]
        dt = later[DT]
        det = later[PP_XX] * later[PP_VV] - later[PP_XV] ** 2
        if det <= 0.0:
            x, v, p_xx, p_xv, p_vv = row[X], row[V], row[P_XX], row[P_XV], row[P_VV]
            continue
        m_xx, m_vx = row[P_XX] + dt * row[P_XV], row[P_XV] + dt * row[P_VV]  # P A'
        m_xv, m_vv = row[P_XV], row[P_VV]
        g_xx = (m_xx * later[PP_VV] - m_xv * later[PP_XV]) / det
        g_xv = (m_xv * later[PP_XX] - m_xx * later[PP_XV]) / det
        g_vx = (m_vx * later[PP_VV] - m_vv * later[PP_XV]) / det
        g_vv = (m_vv * later[PP_XX] - m_vx * later[PP_XV]) / det
        e_x, e_v = x - later[X_P], v - later[V_P]
        d_xx, d_xv, d_vv = p_xx - later[PP_XX], p_xv - later[PP_XV], p_vv - later[PP_VV]
        x, v = row[X] + g_xx * e_x + g_xv * e_v, row[V] + g_vx * e_x + g_vv * e_v
        s_x, s_v = d_xx * g_xx + d_xv * g_xv, d_xv * g_xx + d_vv * g_xv
        t_x, t_v = d_xx * g_vx + d_xv * g_vv, d_xv * g_vx + d_vv * g_vv
        p_xx = row[P_XX] + g_xx * s_x + g_xv * s_v
        p_xv = row[P_XV] + g_xx * t_x + g_xv * t_v
        p_vv = row[P_VV] + g_vx * t_x + g_vv * t_v
    return x, v, max(p_vv, 0.0)
