"""SH-ADD: Skyhook below the crossing p[1] [Hz], acceleration-driven damping above; duty p[0]."""

from __future__ import annotations

import math

from er_models.model import Array

from er_studies.control.peers.sample import A_S, V_S, V, compiled


@compiled
def duty(p: Array, s: Array) -> float:
    """The duty; source: Savaresi and Spelta 2007, ASME J. Dyn. Syst. Meas. Control 129 (4)."""
    slow = s[A_S] ** 2 <= (2.0 * math.pi * p[1] * s[V_S]) ** 2
    brakes = (s[V_S] if slow else s[A_S]) * s[V] > 0.0
    return float(p[0]) if brakes else 0.0
