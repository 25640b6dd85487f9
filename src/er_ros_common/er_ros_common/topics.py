"""The graph's topics: type, rate and quality of service of each name, each written down once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Final

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from er_models.constants import SAMPLE_RATE
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock

from er_common import topic_names
from er_damper_msgs.msg import (
    DamperForce,
    FaultEstimate,
    NodeStatus,
    PwmDuty,
    RoadDisplacement,
    SuspensionAcceleration,
    SuspensionDeflection,
)
from er_ros_common import qos


@dataclass(frozen=True, slots=True, eq=False)
class Topic:
    """One topic: what it carries, how often [Hz], and the quality of service of either end; equal only to itself.

    every_tick: whether every tick of the plant has one; others may be slower. parts: numbers of its messages that
    need not be there, each beside a field ``PART_valid``.
    """

    name: str
    type: type[Any]
    text: str
    rate: float
    publisher: QoSProfile
    subscriber: QoSProfile
    every_tick: bool = True
    parts: tuple[str, ...] = ()

    def lacking(self, message: Any) -> str:
        """The first part that a message comes without; empty where it is whole."""
        for part in self.parts:
            if not getattr(message, f"{part}_valid"):
                return part
        return ""

    @property
    def numbers(self) -> tuple[str, ...]:
        """Fields of its messages that are numbers with a unit."""
        kinds = self.type.get_fields_and_field_types()
        return tuple(field for field, kind in kinds.items() if kind == "double")

    @property
    def type_name(self) -> str:
        """Type as in `ros2 topic info`."""
        package = self.type.__module__.split(".")[0]
        return f"{package}/msg/{self.type.__name__}"


def _sensor(name: str, kind: type[Any], text: str) -> Topic:
    return Topic(name, kind, text, SAMPLE_RATE, qos.SENSOR_PUBLISHER, qos.SENSOR_SUBSCRIBER)


ACCELERATION: Final = _sensor(
    topic_names.ACCELERATION, SuspensionAcceleration, "sprung and unsprung acceleration [m/s2]"
)
DEFLECTION: Final = replace(
    _sensor(topic_names.DEFLECTION, SuspensionDeflection, "deflection [m] and its velocity [m/s]"),
    parts=("velocity",),
)
FORCE: Final = _sensor(topic_names.FORCE, DamperForce, "measured damper force [N]")
ROAD: Final = _sensor(topic_names.ROAD, RoadDisplacement, "road displacement [m]")
PWM_APPLIED: Final = _sensor(topic_names.PWM_APPLIED, PwmDuty, "duty after all limits [1]")
PWM_COMMAND: Final = Topic(
    topic_names.PWM_COMMAND,
    PwmDuty,
    "duty asked for [1]",
    SAMPLE_RATE,
    qos.COMMAND_PUBLISHER,
    qos.COMMAND,
)
FORCE_BY: Final = {
    name: _sensor(
        topic_names.estimated_force(name), DamperForce, f"force of the {title} observer [N]"
    )
    for name, title in topic_names.OBSERVERS.items()
}
"""Estimated forces, by observer."""
FAULT: Final = replace(
    _sensor(topic_names.FAULT, FaultEstimate, "effectiveness f1, f2, f3 [1]"), every_tick=False
)
RECORDED: Final = Topic(
    "~/recorded",
    DiagnosticStatus,
    "number of the last message that is written, by topic",
    10.0,
    qos.STATUS,
    qos.STATUS,
    every_tick=False,
)
STATUS: Final = Topic("~/status", NodeStatus, "health of the node", 10.0, qos.STATUS, qos.STATUS)
DIAGNOSTICS: Final = Topic(
    topic_names.DIAGNOSTICS,
    DiagnosticArray,
    "health of the node",
    1.0,
    qos.DIAGNOSTICS,
    qos.DIAGNOSTICS,
)
CLOCK: Final = Topic(
    topic_names.CLOCK, Clock, "simulated time", SAMPLE_RATE, qos.DIAGNOSTICS, qos.SENSOR_SUBSCRIBER
)

#: what a bag needs to compare a model with a measurement
MEASUREMENTS: Final = (ACCELERATION, DEFLECTION, FORCE, ROAD, PWM_COMMAND, PWM_APPLIED)
ESTIMATES: Final = (*FORCE_BY.values(), FAULT)
