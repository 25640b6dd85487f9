"""Names of the graph's topics, each written down once; what they carry is in `topics`. No ROS here."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

ACCELERATION: Final = "sensors/acceleration"
DEFLECTION: Final = "sensors/deflection"
FORCE: Final = "sensors/force"
ROAD: Final = "sensors/road"
PWM_APPLIED: Final = "pwm/applied"
PWM_COMMAND: Final = "pwm/command"
FAULT: Final = "fault/estimate"
DIAGNOSTICS: Final = "/diagnostics"
CLOCK: Final = "/clock"
OBSERVERS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "unified": "unified",
        "nlpv_polytopic": "NLPV polytopic",
        "nlpv_gridding": "NLPV gridding",
    }
)
"""Observers of the damper force: name and title. Theorem, gains, node and topic of each are found by the name."""


def estimated_force(observer: str) -> str:
    """Where an observer of `OBSERVERS` says its damper force."""
    return f"force/{observer}"
