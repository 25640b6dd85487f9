r"""Sums of weighted regressions y = phi beta + noise: the information of a stretch of time, compiled.

A sum is one array (SIZE,): the lower triangle of :math:`\sum \phi \phi^T / r` row by row, :math:`\sum \phi y / r`,
:math:`\sum y^2 / r` and the number of rows. Sums of two stretches add up.
"""

from __future__ import annotations

import math

from er_models.model import Array

from er_observers.observers.compiled import compiled

N = 8
"""Unknowns beta: see `regression.NAMES`."""
TRIANGLE = N * (N + 1) // 2
SIZE = TRIANGLE + N + 2
POWER, ROWS = SIZE - 2, SIZE - 1


@compiled
def add(total: Array, phi: Array, y: float, weight: float) -> None:
    """Add one row, phi (N,) and y, of the weight 1 / r, in place."""
    at = 0
    for i in range(N):
        share = weight * phi[i]
        for j in range(i + 1):
            total[at] += share * phi[j]
            at += 1
        total[TRIANGLE + i] += share * y
    total[POWER] += weight * y * y
    total[ROWS] += 1.0


@compiled
def factorise(total: Array, prior: Array, scale: Array, temper: float, L: Array) -> float:
    """Cholesky factor L (N, N) of prior + temper D total D, D = diag(scale); its log determinant."""
    at, log_det = 0, 0.0
    for i in range(N):
        for j in range(i + 1):
            value = prior[at] + temper * scale[i] * scale[j] * total[at]
            for k in range(j):
                value -= L[i, k] * L[j, k]
            if i == j:
                L[i, i] = math.sqrt(max(value, 1e-300))
                log_det += 2.0 * math.log(L[i, i])
            else:
                L[i, j] = value / L[j, j]
            at += 1
    return log_det


@compiled
def forward(
    total: Array, prior: Array, scale: Array, temper: float, L: Array, half: Array
) -> float:
    """Fill half (N,) = L^-1 m with m = prior's + temper D total's vector; returns m' (L L')^-1 m."""
    power = 0.0
    for i in range(N):
        value = prior[TRIANGLE + i] + temper * scale[i] * total[TRIANGLE + i]
        for k in range(i):
            value -= L[i, k] * half[k]
        half[i] = value / L[i, i]
        power += half[i] * half[i]
    return power


@compiled
def backward(L: Array, half: Array) -> None:
    """Make of half (N,) the most likely unknowns beta, in place."""
    for i in range(N - 1, -1, -1):
        value = half[i]
        for k in range(i + 1, N):
            value -= L[k, i] * half[k]
        half[i] = value / L[i, i]


@compiled
def misfit(total: Array, scale: Array, beta: Array) -> float:
    """Sum of the squared residuals over r for the unknowns D beta (N,)."""
    chi, at = total[POWER], 0
    for i in range(N):
        b = scale[i] * beta[i]
        chi -= 2.0 * b * total[TRIANGLE + i]
        for j in range(i):
            chi += 2.0 * b * scale[j] * beta[j] * total[at]
            at += 1
        chi += b * b * total[at]
        at += 1
    return float(chi)
