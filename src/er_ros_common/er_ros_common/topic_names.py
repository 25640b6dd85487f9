"""Names of the graph's topics, each written down once; what they carry is in `topics`. No ROS here."""

from __future__ import annotations

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


def estimated_force(observer: str) -> str:
    """Where the observer of a name says its damper force."""
    return f"force/{observer}"
