"""The numbers of a moving horizon, compiled: the start of some samples that explains them best.

The peer `moving horizon` of the observers (er_studies) says what is minimised, and what p holds.
"""

from __future__ import annotations

import math

import numpy as np
from er_models.model import Array

from er_observers.observers.compiled import compiled
from er_observers.observers.gate import mean_gate

_ROUNDS = 2
_STEPS = (1e-7, 1e-5, 1e-4)


@compiled
def along(p: Array, rows: Array, first: Array) -> Array:
    """State (3,) one sample on from the first of the rows."""
    dt, a, b = rows[1, 0] - rows[0, 0], rows[0, 1], rows[1, 1]
    out = np.empty(3)
    out[0] = first[0] + dt * first[1] + dt * dt * (a / 3.0 + b / 6.0)
    out[1] = first[1] + 0.5 * dt * (a + b)
    gate, _ = mean_gate(p[6] * first[0] + p[7] * first[1], p[6] * out[0] + p[7] * out[1])
    keep = math.exp(-p[5] * dt)
    out[2] = keep * first[2] + (1.0 - keep) * p[4] * rows[0, 4] * gate
    return out


@compiled
def _residuals(p: Array, rows: Array, first: Array, out: Array) -> Array:
    """Weighted residuals (2 N,) of a start (3,), into out; returns the last state."""
    x, balance = first.copy(), p[11] * p[0] * p[8]
    for k in range(rows.shape[0]):
        if k > 0:
            x = along(p, rows[k - 1 : k + 1], x)
        force = p[2] * x[0] + p[3] * x[1] + x[2]
        out[2 * k] = (x[0] - rows[k, 3]) / p[9]
        out[2 * k + 1] = (p[0] * rows[k, 2] + p[1] * x[0] + force) / balance
    return x


@compiled
def solved(p: Array, rows: Array, prior: Array) -> tuple[Array, Array]:
    """Start (3,) of the rows, sought from the prior, and the state at their end."""
    n, first = 2 * rows.shape[0], prior.copy()
    r, moved, J = np.empty(n), np.empty(n), np.empty((3, n))
    spread = np.array([p[9], 0.01, 1.0]) * p[10]
    for _ in range(_ROUNDS):
        _residuals(p, rows, first, r)
        for i in range(3):
            there = first.copy()
            there[i] += _STEPS[i]
            _residuals(p, rows, there, moved)
            for k in range(n):
                J[i, k] = (moved[k] - r[k]) / _STEPS[i]
        H, g = np.zeros((3, 3)), np.zeros(3)
        for i in range(3):
            H[i, i] += 1.0 / spread[i] ** 2
            g[i] += (prior[i] - first[i]) / spread[i] ** 2
            for k in range(n):
                g[i] -= J[i, k] * r[k]
                for j in range(3):
                    H[i, j] += J[i, k] * J[j, k]
        first = first + np.linalg.solve(H, g)
    return first, _residuals(p, rows, first, r)
