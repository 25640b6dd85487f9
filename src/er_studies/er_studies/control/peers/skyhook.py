"""Two-state Skyhook (3.81): duty p[0] where the damper brakes the body."""

from __future__ import annotations

from er_models.model import Array

from er_studies.control.peers.sample import V_S, V, compiled


@compiled
def duty(p: Array, s: Array) -> float:
    """The duty; source: Karnopp, Crosby and Harwood 1974."""
    return float(p[0]) if s[V_S] * s[V] >= 0.0 else 0.0
