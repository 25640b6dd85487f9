"""The programs of the package that are nodes, each declared here and nowhere else."""

from __future__ import annotations

from typing import Final

from er_common.program import Program
from er_common.topics import (
    ACCELERATION,
    DEFLECTION,
    FORCE,
    MODEL_FORCE,
    MODEL_RESIDUAL,
    PWM_APPLIED,
    SENSORS,
)

RECORDER: Final = Program(
    "recorder",
    "er_model_lab",
    "Records topics into a rosbag2 folder (MCAP or sqlite3) until it is stopped.",
    listens=SENSORS,
)
MONITOR: Final = Program(
    "model_monitor",
    "er_model_lab",
    "A model beside the running damper: its force and error, an alarm when it no longer explains, and what it lacks.",
    core="ros_monitor",
    asked="whether a model is watched beside the damper",
    listens=(ACCELERATION, DEFLECTION, PWM_APPLIED),
    uses=(FORCE,),
    says=MODEL_FORCE,
    beside=(MODEL_RESIDUAL,),
    model=True,
    rate=True,
)
PROGRAMS: Final = (RECORDER, MONITOR)
