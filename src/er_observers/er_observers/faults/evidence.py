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

from er_observers.faults.sums import SIZE, TRIANGLE, N, backward, factorise, forward
from er_observers.observers.compiled import compiled
from er_observers.observers.copies import copy_row, scale_row

NONE, ELECTRICAL, LEAKAGE, DEFORMATION, COMBINED = range(5)
KINDS = 5
SMALLEST = 0.02
"""Least share [1] that is told from none: below it the columns vanish."""
_STEP, _FINEST = 0.02, 1e-3
_HALVES = 5
_ANY = 0.5
_NEWTON = 4
_MIXED = 4
_LEAST_CURVATURE = 1e-3
_ROOT_2, _ROOT_PI = math.sqrt(2.0), math.sqrt(math.pi)
_FAR = 4.0
"""Deviations, over the root of 2, beyond which the tail of a Gaussian is its asymptote: to 3 %."""
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
def log_within(value: float, deviation: float) -> float:
    """Logarithm of the probability that a Gaussian lies in 0 to 1.

    Far outside it falls with the square of the distance: a fault whose likeliest factor lies outside is as likely as
    its nearest factor inside.
    """
    low, high = -value / (deviation * _ROOT_2), (1.0 - value) / (deviation * _ROOT_2)
    if low > 0.0:
        low, high = -high, -low
    if high > -_FAR:
        return math.log(0.5 * (math.erf(high) - math.erf(low)))
    return -high * high - math.log(-2.0 * _ROOT_PI * high)


@compiled
def single(
    kind: int, total: Array, prior: Array, temper: float, s: float, room: Array
) -> tuple[float, float, float]:
    """Most likely factor of one fault from the start s on, its deviation, and ln Z of that fault."""
    shares, step, curvature = np.empty(3), _STEP, _LEAST_CURVATURE
    here = _of_one(kind, total, prior, temper, s, shares, room)
    for _ in range(_NEWTON):
        below = _of_one(kind, total, prior, temper, s - step, shares, room)
        above = _of_one(kind, total, prior, temper, s + step, shares, room)
        curvature = max((2.0 * here - below - above) / step**2, _LEAST_CURVATURE)
        move = (above - below) / (2.0 * step) / curvature
        move = min(max(move, -0.5), 0.5)
        for _ in range(_HALVES):
            new = min(max(s + move, SMALLEST), 1.3)
            there = _of_one(kind, total, prior, temper, new, shares, room)
            if there >= here:
                break
            move *= 0.5
        if there >= here:
            s, here = new, there
        step = min(max(1.0 / math.sqrt(curvature), _FINEST), _STEP)
        if abs(move) < 1e-3:
            break
    deviation = 1.0 / math.sqrt(curvature)
    return s, deviation, here + 0.5 * _LN_2_PI + math.log(deviation) + log_within(s, deviation)


@compiled
def _of_one(
    kind: int, total: Array, prior: Array, temper: float, s: float, shares: Array, room: Array
) -> float:
    """Ln Z of one fault of the factor s."""
    shares_of(kind, s, shares)
    return float(log_evidence(total, prior, temper, shares, room))


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
    step, move, det = np.full(3, _STEP), np.empty(3), 1.0
    here = log_evidence(total, prior, temper, a, room)
    for _ in range(_MIXED):
        _quadratic(total, prior, temper, a, here, trial, room, step, g, H)
        det = _inverse(H, P)
        for i in range(3):
            move[i] = P[i, 0] * g[0] + P[i, 1] * g[1] + P[i, 2] * g[2]
            move[i] = min(max(move[i], -0.5), 0.5)
            step[i] = min(max(1.0 / math.sqrt(H[i, i]), _FINEST), _STEP)
        for _ in range(_HALVES):
            for i in range(3):
                trial[i] = min(max(a[i] + move[i], SMALLEST), 1.3)
            there = log_evidence(total, prior, temper, trial, room)
            if there >= here:
                copy_row(trial, a)
                here = there
                break
            scale_row(0.5, move)
    factors[0], factors[1], factors[2] = a[2] / a[1], a[0], a[1] / a[0]
    spread[1] = math.sqrt(max(P[0, 0], 1e-12))
    third = P[1, 1] - 2.0 * factors[2] * P[0, 1] + factors[2] ** 2 * P[0, 0]
    first = P[2, 2] - 2.0 * factors[0] * P[1, 2] + factors[0] ** 2 * P[1, 1]
    spread[2] = math.sqrt(max(third, 1e-12)) / a[0]
    spread[0] = math.sqrt(max(first, 1e-12)) / a[1]
    log_z = here + 1.5 * _LN_2_PI - 0.5 * math.log(det)
    log_z -= math.log(a[0] * a[1])  # from shares to factors
    for i in range(3):
        log_z += log_within(factors[i], spread[i])
        factors[i] = min(max(factors[i], 0.0), 1.0)
    return log_z


@compiled
def free(total: Array, first: Array, temper: float, room: Array) -> None:
    """Leave unknowns of which the shares may be anything in room[N:2 N]: a beginning; first (2 N,): see `decision`."""
    prior, ones = np.zeros(SIZE), np.ones(3)
    for i in range(N):
        precision = (_ANY if i < 3 else first[N + i]) ** -2
        prior[i * (i + 1) // 2 + i] = precision
        prior[TRIANGLE + i] = precision * first[i]
    unknowns(total, prior, temper, ones, room)
    for i in range(3):
        room[N + i] = min(max(room[N + i], SMALLEST), 1.0)


@compiled
def _quadratic(
    total: Array, prior: Array, temper: float, a: Array, here: float, trial: Array, room: Array,
    step: Array, g: Array, H: Array,
) -> None:  # fmt: skip
    """Gradient g (3,) and negative Hessian H (3, 3) of ln Z at the shares a (3,), made safely definite."""
    for i in range(3):
        copy_row(a, trial)
        trial[i] = a[i] + step[i]
        above = log_evidence(total, prior, temper, trial, room)
        trial[i] = a[i] - step[i]
        below = log_evidence(total, prior, temper, trial, room)
        g[i] = (above - below) / (2.0 * step[i])
        H[i, i] = max((2.0 * here - above - below) / step[i] ** 2, 1.0)
    for i in range(3):
        for j in range(i):
            h, k = step[i], step[j]
            copy_row(a, trial)
            trial[i], trial[j] = a[i] + h, a[j] + k
            both = log_evidence(total, prior, temper, trial, room)
            cross = (here - both + g[i] * h + g[j] * k) / (h * k)
            cross -= 0.5 * (H[i, i] * h / k + H[j, j] * k / h)
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
        for i in range(3):
            for j in range(3):
                P[i, j] /= det
        return float(det)
    P[:] = 0.0
    for i in range(3):
        P[i, i] = 1.0 / H[i, i]
    return float(H[0, 0] * H[1, 1] * H[2, 2])
