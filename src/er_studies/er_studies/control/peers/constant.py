"""A constant duty p[0]."""

from __future__ import annotations

from er_models.model import Array

from er_studies.control.peers.sample import compiled


@compiled
def duty(p: Array, _s: Array) -> float:
    """The duty."""
    return float(p[0])
