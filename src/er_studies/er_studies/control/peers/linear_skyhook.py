"""Linear Skyhook: the yield force is p[0] [N s/m] times the body's velocity, where the damper can make it."""

from __future__ import annotations

from er_models.model import Array

from er_studies.control.peers.sample import FULL, GATE, LEAST_GATE, V_S, compiled


@compiled
def duty(p: Array, s: Array) -> float:
    """The duty; source: Karnopp, Crosby and Harwood 1974."""
    if s[V_S] * s[GATE] <= 0.0:
        return 0.0
    return float(p[0] * abs(s[V_S]) / (s[FULL] * max(abs(s[GATE]), LEAST_GATE)))
