"""Unscented Kalman filter: the covariance is that of 2 n points which the model itself moves.

Points at sqrt(n) standard deviations with equal weights: the scaled transform with alpha 1, beta 0
and kappa 0, whose centre has no weight (the cubature rule).

Source: Julier and Uhlmann 2004; Arasaratnam and Haykin 2009.
"""

from __future__ import annotations

import numpy as np
from er_models.model import Array

from er_observers.filters.correct import correct
from er_observers.filters.flow import flow
from er_observers.observers.compiled import compiled


@compiled
def root(P: Array, out: Array) -> None:
    """Lower triangle out (n, n) with out out' = P; a direction without spread stays without."""
    n = P.shape[0]
    out[:, :] = 0.0
    for j in range(n):
        left = P[j, j]
        for k in range(j):
            left -= out[j, k] * out[j, k]
        if left > 1e-14 * P[j, j]:
            out[j, j] = np.sqrt(left)
            for i in range(j + 1, n):
                total = P[i, j]
                for k in range(j):
                    total -= out[i, k] * out[j, k]
                out[i, j] = total / out[j, j]


@compiled
def points_about(x: Array, P: Array, reach: float, points: Array) -> None:
    """Fill points (2 n or more, n): x (n,) and `reach` deviations along each root of P (n, n), up and then down."""
    n = x.shape[0]
    L = np.empty((n, n))
    root(P, L)
    for k in range(n):
        for i in range(n):
            step = reach * L[i, k]
            points[k, i], points[n + k, i] = x[i] + step, x[i] - step


@compiled
def predict_unscented(
    linear: Array, kick: Array, gamma: Array, noise: Array, duty: float, x: Array, P: Array
) -> None:
    """Move x (n,) and P (n, n) one substep on, in place; noise (n, n) comes at its end."""
    n = x.shape[0]
    points = np.empty((2 * n, n))
    points_about(x, P, np.sqrt(float(n)), points)
    x[:] = 0.0
    for k in range(2 * n):
        flow(linear, kick, gamma, duty, points[k])
        for i in range(n):
            x[i] += points[k, i] / (2 * n)
    for i in range(n):
        for j in range(i + 1):
            total = noise[i, j]
            for k in range(2 * n):
                total += (points[k, i] - x[i]) * (points[k, j] - x[j]) / (2 * n)
            P[i, j] = P[j, i] = total


@compiled
def unscented_sample(
    linear: Array, kick: Array, gamma: Array, noise: Array, C: Array, variance: Array,
    duty: float, steps: int, y: Array, x: Array, P: Array,
) -> None:  # fmt: skip
    """Predict over all substeps of a sample, with new points for each, then correct; x and P in place."""
    for _ in range(steps):
        predict_unscented(linear, kick, gamma, noise, duty, x, P)
    if np.isfinite(y).all():
        correct(C, variance, y, x, P)
