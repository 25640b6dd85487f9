"""The linear part of both filters: accelerations are linear in the state, so the correction is Kalman's own."""

from __future__ import annotations

import numpy as np
from er_models.model import Array

from er_observers.observers.compiled import compiled


@compiled
def correct(C: Array, variance: Array, y: Array, x: Array, P: Array) -> float:
    """Correct x (n,) and its covariance P (n, n), in place, by y (m,), one output after another.

    variance (m,): of each output. Joseph's form keeps P symmetric and positive (Bierman 1977). Returns the mean square
    of the innovations over their variances.
    """
    n = x.shape[0]
    spread, gain, rows, far = np.empty(n), np.empty(n), np.empty((n, n)), 0.0
    for k in range(y.shape[0]):
        total, innovation = variance[k], y[k]
        for i in range(n):
            spread[i] = 0.0
            for j in range(n):
                spread[i] += P[i, j] * C[k, j]
            total += C[k, i] * spread[i]
            innovation -= C[k, i] * x[i]
        far += innovation * innovation / total
        for i in range(n):
            gain[i] = spread[i] / total
            x[i] += gain[i] * innovation
        for i in range(n):
            for j in range(n):
                rows[i, j] = P[i, j] - gain[i] * spread[j] - spread[i] * gain[j]
        for i in range(n):
            for j in range(n):
                P[i, j] = rows[i, j] + gain[i] * total * gain[j]
    return float(far / y.shape[0])
