"""The programs of this package, and those of all packages by what they are in the graph."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from er_common.program import CONTROLLER, Program
from er_common.topics import PWM_COMMAND
from er_observers.programs import OBSERVERS
from er_plant_sim.programs import BRIDGE, PLANT

from er_ftc_controller import programs as controller_programs
from er_model_lab import programs as lab_programs
from er_observers import programs as observer_programs
from er_plant_sim import programs as plant_programs

PACKAGE = "er_bringup"
COMPOSED: Final = Program(
    "composed", PACKAGE, "Any set of nodes in one process.", module="ros_composed"
)
JOINT: Final = Program(
    "ros2_control_joint",
    PACKAGE,
    "A corner as a joint of ros2_control: states and commands as sensor_msgs/JointState.",
)
IMU_ADAPTER: Final = Program(
    "imu_adapter",
    PACKAGE,
    "Two sensor_msgs/Imu of a vehicle as the accelerations of a corner.",
)
ACCEL_ADAPTER: Final = Program(
    "accel_adapter",
    PACKAGE,
    "Two geometry_msgs/AccelStamped of a vehicle as the accelerations of a corner.",
)
AUTOWARE_ADAPTER: Final = Program(
    "autoware_adapter",
    PACKAGE,
    "Autoware's velocity report of a vehicle as the load of braking and cornering on its body.",
)
JOINT_ADAPTER: Final = Program(
    "joint_adapter",
    PACKAGE,
    "The joint of a strut in sensor_msgs/JointState as the deflection of a corner.",
)
DYNAMIC_JOINT_ADAPTER: Final = Program(
    "dynamic_joint_adapter",
    PACKAGE,
    "The joint of a strut in control_msgs/DynamicJointState as the deflection of a corner.",
)
ADAPTERS: Final = (
    IMU_ADAPTER, ACCEL_ADAPTER, JOINT_ADAPTER, DYNAMIC_JOINT_ADAPTER, AUTOWARE_ADAPTER,
)  # fmt: skip
"""What makes messages of a vehicle into ours."""
PROGRAMS: Final = (COMPOSED, JOINT, *ADAPTERS)

EVERY: Final = (
    *observer_programs.PROGRAMS,
    *controller_programs.PROGRAMS,
    *plant_programs.PROGRAMS,
    *lab_programs.PROGRAMS,
    *PROGRAMS,
)
"""The programs of all packages."""
SOURCES: Final = (PLANT, BRIDGE)
"""What measures, one of them in a graph; the end of it is the end of all."""
CONTROLLERS: Final[Mapping[str, Program]] = MappingProxyType(
    {program.key: program for program in EVERY if program.kind == CONTROLLER}
)
ASKED: Final = tuple(program for program in EVERY if program.asked)
"""Those with an argument of their own."""
ANSWERING: Final = (*OBSERVERS.values(), *ASKED, *CONTROLLERS.values())
"""Those that answer samples."""
ESTIMATES: Final = tuple(
    topic for program in ANSWERING for topic in program.said if topic is not PWM_COMMAND
)
"""What is said of the car beside the measurements."""
CORES: Final[Mapping[str, Program]] = MappingProxyType(
    {program.name: program for program in EVERY if program.core}
)
"""Those that a recording can be played to, by name."""
