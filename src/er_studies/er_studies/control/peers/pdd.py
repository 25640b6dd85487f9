"""Power-driven damper: least power from suspension to body; duty to p[0], stiffness p[1], passive damping p[2]."""

from __future__ import annotations

from er_models.model import Array

from er_studies.control.peers.sample import FULL, GATE, V, X, compiled


@compiled
def duty(p: Array, s: Array) -> float:
    """The duty; source: Morselli and Zanasi 2008, Mechatronics 18 (7)."""
    spring, passive, full = p[1] * s[X], p[2] * s[V], s[FULL] * p[0] * s[GATE]
    if (spring + passive) * s[V] >= 0.0:
        return float(p[0])
    if (spring + passive + full) * s[V] < 0.0:
        return 0.0
    return float(-(spring + passive) / full * p[0]) if abs(s[GATE]) > 1e-3 else float(0.5 * p[0])
