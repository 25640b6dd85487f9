"""Extended Kalman filter: the covariance moves with the Jacobian of the model along the estimate.

Source: Jazwinski 1970, chapter 8.
"""

from __future__ import annotations

import numpy as np
from er_models.model import Array

from er_observers.filters.correct import correct
from er_observers.filters.flow import flow, jacobian
from er_observers.observers.compiled import compiled


@compiled
def predict_extended(
    linear: Array, kick: Array, gamma: Array, noise: Array, duty: float, n_sub: int,
    x: Array, P: Array,
) -> None:  # fmt: skip
    """Move x (n,) and P (n, n) n_sub substeps on, in place; noise (n, n) comes with each."""
    n = x.shape[0]
    J, half = np.empty((n, n)), np.empty((n, n))
    for _ in range(n_sub):
        slopes = flow(linear, kick, gamma, duty, x)
        jacobian(linear, kick, gamma, duty, slopes, J)
        for i in range(n):
            for j in range(n):
                half[i, j] = 0.0
                for k in range(n):
                    half[i, j] += J[i, k] * P[k, j]
        for i in range(n):
            for j in range(i + 1):
                total = noise[i, j]
                for k in range(n):
                    total += half[i, k] * J[j, k]
                P[i, j] = P[j, i] = total


@compiled
def extended_sample(
    linear: Array, kick: Array, gamma: Array, noise: Array, C: Array, variance: Array,
    duty: float, steps: int, y: Array, x: Array, P: Array,
) -> None:  # fmt: skip
    """Predict over all substeps of a sample, then correct by y (m,) where it is finite; x and P in place."""
    predict_extended(linear, kick, gamma, noise, duty, steps, x, P)
    if np.isfinite(y).all():
        correct(C, variance, y, x, P)
