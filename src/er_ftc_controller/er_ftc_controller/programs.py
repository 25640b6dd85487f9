"""The programs of the package, each declared here and nowhere else."""

from __future__ import annotations

from typing import Final

from er_common.program import CONTROLLER, Program
from er_common.topics import ACCELERATION, DEFLECTION, FAULT, PWM_APPLIED, PWM_COMMAND

PACKAGE = "er_ftc_controller"
SKYHOOK: Final = Program(
    "skyhook_controller",
    PACKAGE,
    "Two-state Skyhook (3.81): full field where the damper brakes the body.",
    core="ros_skyhook",
    kind=CONTROLLER,
    listens=(ACCELERATION, DEFLECTION),
    says=PWM_COMMAND,
)
FTC: Final = Program(
    "ftc_controller",
    PACKAGE,
    "Fault-tolerant LPV control: domain (6.14), rho (6.16), LPV controller (6.27), inner force loop (2.10).",
    core="ros_ftc",
    kind=CONTROLLER,
    listens=(ACCELERATION, DEFLECTION),
    uses=(FAULT, PWM_APPLIED),
    says=PWM_COMMAND,
    model=True,
    rate=True,
    gains="lpv_ftc",
)
BODY: Final = Program(
    "body_controller",
    PACKAGE,
    "Heave, roll and pitch of a whole car by its four dampers: a clipped linear-quadratic regulator.",
    module="ros_body",
)
PROGRAMS: Final = (SKYHOOK, FTC, BODY)
