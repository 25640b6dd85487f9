"""The programs of the package, each declared here and nowhere else."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from er_common.program import OBSERVER, Program
from er_common.topics import ACCELERATION, DEFLECTION, FAULT, PWM_APPLIED, estimated_force

PACKAGE = "er_observers"


def observer(name: str, title: str, text: str) -> Program:
    """The node of a theorem: NAME_observer runs the gains that theorem NAME makes; its force is on force/NAME."""
    theorem = name.removesuffix(f"_{OBSERVER}")
    return Program(
        name,
        PACKAGE,
        f"Damper force from two accelerometers: {text}",
        title,
        core="ros_observer",
        kind=OBSERVER,
        listens=(ACCELERATION, PWM_APPLIED),
        says=estimated_force(theorem),
        model=True,
        gains=theorem,
    )


FAULT_ESTIMATOR: Final = Program(
    "fault_estimator",
    PACKAGE,
    "What faults have left of the damper (f1 electrical, f2 leakage, f3 deformation), and which fault it is: "
    "from accelerations, deflection and duty.",
    core="ros_faults",
    asked="whether faults are estimated",
    listens=(ACCELERATION, DEFLECTION, PWM_APPLIED),
    says=FAULT,
    model=True,
    rate=True,
)
PROGRAMS: Final = (
    observer("unified_observer", "unified", "unified H-infinity observer, the road decoupled."),
    observer(
        "nlpv_polytopic_observer",
        "NLPV polytopic",
        "NLPV observer with constant Lyapunov function.",
    ),
    observer(
        "nlpv_gridding_observer", "NLPV gridding", "NLPV observer with gains on a grid of duties."
    ),
    FAULT_ESTIMATOR,
)
OBSERVERS: Final[Mapping[str, Program]] = MappingProxyType(
    {program.key: program for program in PROGRAMS if program.kind == OBSERVER}
)
"""Observers of the damper force by the name of their theorem."""
