"""Clipped linear-quadratic regulator with the yield force as a state, so that its inverse makes up for the lag.

p: gain of [deflection, velocity of the body, tyre, velocity of the wheel, yield force], (5,).
"""

from __future__ import annotations

from er_models.model import Array

from er_studies.control.peers.sample import (
    FORCE,
    FULL,
    GATE,
    LEAST_GATE,
    TYRE,
    V_S,
    V,
    X,
    compiled,
)


@compiled
def duty(p: Array, s: Array) -> float:
    """The duty; source: Hrovat 1997, Automatica 33 (10)."""
    goal = -(
        p[0] * s[X] + p[1] * s[V_S] + p[2] * s[TYRE] + p[3] * (s[V_S] - s[V]) + p[4] * s[FORCE]
    )
    gate = max(abs(s[GATE]), LEAST_GATE)
    return float(goal / (s[FULL] * (gate if s[GATE] >= 0.0 else -gate)))
