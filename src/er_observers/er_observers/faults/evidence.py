r"""How likely each fault is: the regression of a stretch of time under shares of the damper's three terms, compiled.

A fault scales columns: stiffness by :math:`f_2`, viscosity by :math:`f_2 f_3`, field by :math:`f_1 f_2 f_3`. For given
shares the unknowns are Gaussian, so that their evidence is exact,

.. math::  \ln Z = \tfrac12 m^T A^{-1} m - \tfrac12 \ln \det A, \quad
           A = \Lambda_0 + D W D, \quad m = \eta_0 + D w

with what the healthy damper has taught as prior (Lambda_0, eta_0). The most likely shares come from Newton steps, the
evidence of a kind of fault from the Gaussian around them, cut off where a factor would leave 0 to 1.

Source: MacKay 1992 (evidence, Laplace's method); thesis (6.8).
"""

from __future__ import annotations

import math

import numpy as np
from er_models.model import Array

from er_observers.faults.sums import N, backward, factorise, forward
from er_observers.observers.compiled import compiled

NONE, ELECTRICAL, LEAKAGE, DEFORMATION, COMBINED = range(5)
KINDS = 5
SMALLEST = 0.02
"""Least share [1] that is told from none: below it the columns vanish."""
_STEP = 0.02
_NEWTON = 4
_MIXED = 3
_LEAST_CURVATURE = 1e-3
_ROOT_2 = math.sqrt(2.0)
_LN_2_PI = math.log(2.0 * math.pi)


@compiled
def log_evidence(total: Array, prior: Array, temper: float, shares: Array, room: Array) -> float:
    """Logarithm of Z for the shares (3,) of stiffness, viscosity and field; room (2 N + N N,) is written over."""
    scale, half, L = room[:N], room[N : 2 * N], room[2 * N :].reshape((N, N))
    scale[:] = 1.0
    scale[0], scale[1], scale[2] = shares[0], shares[1], shares[2]
    scale[5], scale[6], scale[7] = shares[2], shares[2], shares[2]
    log_det = factorise(total, prior, scale, temper, L)
    return 0.5 * (forward(total, prior, scale, temper, L, half) - log_det)


@compiled
def unknowns(total: Array, prior: Array, temper: float, shares: Array, room: Array) -> None:
    """Leave the most likely unknowns for these shares in room[N:2 N], their scale in room[:N]."""
    log_evidence(total, prior, temper, shares, room)
    backward(room[2 * N :].reshape((N, N)), room[N : 2 * N])


@compiled
def shares_of(kind: int, s: float, shares: Array) -> None:
    """Fill the shares (3,) that one fault of the factor s leaves."""
    shares[0] = s if kind == LEAKAGE else 1.0
    shares[1] = s if kind in (LEAKAGE, DEFORMATION) else 1.0
    shares[2] = s if kind != NONE else 1.0


@compiled
def within(value: float, deviation: float) -> float:
    """Probability that a Gaussian lies in 0 to 1."""
    high = math.erf((1.0 - value) / (deviation * _ROOT_2))
    low = math.erf(-value / (deviation * _ROOT_2))
    return max(0.5 * (high - low), 1e-12)


@compiled
def single(
    kind: int, total: Array, prior: Array, temper: float, s: float, room: Array
) -> tuple[float, float, float]:
    """Most likely factor of one fault from the start s on, its deviation, and ln Z of that fault."""
    shares, here = np.empty(3), 0.0
    curvature = _LEAST_CURVATURE
    for _ in range(_NEWTON):
        shares_of(kind, s - _STEP, shares)
        below = log_evidence(total, prior, temper, shares, room)
        shares_of(kind, s + _STEP, shares)
        above = log_evidence(total, prior, temper, shares, room)
        shares_of(kind, s, shares)
        here = log_evidence(total, prior, temper, shares, room)
        curvature = max((2.0 * here - below - above) / _STEP**2, _LEAST_CURVATURE)
        move = (above - below) / (2.0 * _STEP) / curvature
        move = min(max(move, -0.5), 0.5)
        move = min(max(s + move, SMALLEST), 1.3) - s
        here += move * (above - below) / (2.0 * _STEP) - 0.5 * curvature * move * move
        s += move
        if abs(move) < 1e-3:
            break
    deviation = 1.0 / math.sqrt(curvature)
    return s, deviation, here + 0.5 * _LN_2_PI + math.log(deviation * within(s, deviation))


@compiled
def combined(
    total: Array,
    prior: Array,
    temper: float,
    start: Array,
    room: Array,
    factors: Array,
    spread: Array,
) -> float:
    """Fill the most likely factors f1, f2, f3 (3,) and their deviations (3,); returns ln Z of any of them at once.

    start (3,): shares to begin with, left with the likeliest ones. It is the shares that are looked for, as they enter
    the force on their own.
    """
    a, g, H, P, trial = start, np.empty(3), np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    det = 1.0
    for _ in range(_MIXED):
        here = log_evidence(total, prior, temper, a, room)
        _quadratic(total, prior, temper, a, here, trial, room, g, H)
        det = _inverse(H, P)
        for i in range(3):
            move = P[i, 0] * g[0] + P[i, 1] * g[1] + P[i, 2] * g[2]
            a[i] = min(max(a[i] + min(max(move, -0.5), 0.5), SMALLEST), 1.3)
    here = log_evidence(total, prior, temper, a, room)
    factors[0], factors[1], factors[2] = a[2] / a[1], a[0], a[1] / a[0]
    spread[1] = math.sqrt(max(P[0, 0], 1e-12))
    third = P[1, 1] - 2.0 * factors[2] * P[0, 1] + factors[2] ** 2 * P[0, 0]
    first = P[2, 2] - 2.0 * factors[0] * P[1, 2] + factors[0] ** 2 * P[1, 1]
    spread[2] = math.sqrt(max(third, 1e-12)) / a[0]
    spread[0] = math.sqrt(max(first, 1e-12)) / a[1]
    log_z = here + 1.5 * _LN_2_PI - 0.5 * math.log(det)
    log_z -= math.log(a[0] * a[1])  # from shares to factors
    for i in range(3):
        log_z += math.log(within(factors[i], spread[i]))
        factors[i] = min(max(factors[i], 0.0), 1.0)
    return log_z


@compiled
def _quadratic(
    total: Array, prior: Array, temper: float, a: Array, here: float, trial: Array, room: Array,
    g: Array, H: Array,
) -> None:  # fmt: skip
    """Gradient g (3,) and negative Hessian H (3, 3) of ln Z at the shares a (3,), made safely definite."""
    for i in range(3):
        trial[:] = a
        trial[i] = a[i] + _STEP
        above = log_evidence(total, prior, temper, trial, room)
        trial[i] = a[i] - _STEP
        below = log_evidence(total, prior, temper, trial, room)
        g[i] = (above - below) / (2.0 * _STEP)
        H[i, i] = max((2.0 * here - above - below) / _STEP**2, 1.0)
    for i in range(3):
        for j in range(i):
            trial[:] = a
            trial[i], trial[j] = a[i] + _STEP, a[j] + _STEP
            both = log_evidence(total, prior, temper, trial, room)
            cross = (here - both) / _STEP**2 + (g[i] + g[j]) / _STEP - 0.5 * (H[i, i] + H[j, j])
            limit = 0.999 * math.sqrt(H[i, i] * H[j, j])
            H[i, j] = H[j, i] = min(max(cross, -limit), limit)


@compiled
def _inverse(H: Array, P: Array) -> float:
    """Fill P (3, 3) with the inverse of a symmetric H (3, 3), or of its diagonal; the determinant."""
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        P[i, i] = H[j, j] * H[k, k] - H[j, k] ** 2
        P[j, k] = P[k, j] = H[i, j] * H[i, k] - H[i, i] * H[j, k]
    det = H[0, 0] * P[0, 0] + H[0, 1] * P[0, 1] + H[0, 2] * P[0, 2]
    if det > 1e-9 * H[0, 0] * H[1, 1] * H[2, 2] and P[0, 0] > 0.0 and P[1, 1] > 0.0:
        P /= det
        return float(det)
    P[:] = 0.0
    for i in range(3):
        P[i, i] = 1.0 / H[i, i]
    return float(H[0, 0] * H[1, 1] * H[2, 2])
