"""Hybrid predictive control: the car with its gate over 100 ms, every pair of some duties, the passive car after it.

The first duty of a pair acts for two steps of `STEP`, the second for the rest. What counts is the square of the
body's acceleration, deflection and tyre deflection, and at the end what the passive car would still cost. With preview
the road's rates ahead are known, else they are taken for none.
p: A (25), B (5), D (5) of a step, slopes of the gate (2), row of the acceleration (5), weights (3), cost at the end
(25), preview.
"""

from __future__ import annotations

import math

import numpy as np
from er_models.model import Array

from er_studies.control.peers.sample import (
    AHEAD,
    FORCE,
    FULL,
    STEP,
    TYRE,
    V_S,
    WAY,
    V,
    X,
    compiled,
)

DUTIES = 4
FIRST = 2


@compiled
def duty(p: Array, s: Array, u_max: float) -> float:
    """The duty; source: Giorgetti, Bemporad, Tseng and Hrovat 2006, Int. J. Control 79 (5)."""
    best, chosen = np.inf, 0.0
    for i in range(DUTIES):
        for j in range(DUTIES):
            first, then = (i / (DUTIES - 1.0)) ** 2 * u_max, (j / (DUTIES - 1.0)) ** 2 * u_max
            cost = _cost(p, s, first, then, best)
            if cost < best:
                best, chosen = cost, first
    return chosen


@compiled
def _cost(p: Array, s: Array, first: float, then: float, best: float) -> float:
    """Cost of two duties; more than the best one where it is given up."""
    q, ahead, cost = np.empty(5), np.empty(5), 0.0
    q[0], q[1], q[2], q[3], q[4] = s[X], s[V_S], s[TYRE], s[V_S] - s[V], s[FORCE]
    for k in range(AHEAD):
        gate = math.tanh(p[35] * q[0] + p[36] * (q[1] - q[3]))
        goal = s[FULL] * (first if k < FIRST else then) * gate
        rate, felt = s[WAY + k] if p[70] > 0.0 else 0.0, 0.0
        for i in range(5):
            ahead[i] = p[25 + i] * goal + p[30 + i] * rate
            for j in range(5):
                ahead[i] += p[5 * i + j] * q[j]
        for i in range(5):
            q[i] = ahead[i]
            felt += p[37 + i] * q[i]
        cost += STEP * (p[42] * felt**2 + p[43] * q[0] ** 2 + p[44] * q[2] ** 2)
        if cost > best:
            return float(cost)
    for i in range(5):
        for j in range(5):
            cost += q[i] * p[45 + 5 * i + j] * q[j]
    return float(cost)
