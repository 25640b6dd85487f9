"""The graph's topics: name, type, rate and quality of service, each written down once. No ROS here.

A type has the name that `ros2 topic info` shows; its class is imported when somebody asks for it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, cached_property
from importlib import import_module
from typing import Any, Final

from er_models.constants import SAMPLE_RATE

from er_common import quality
from er_common.quality import Ends, Quality


@dataclass(frozen=True, eq=False)
class Topic:
    """One topic: what it carries, how often [Hz], and the quality of service of its ends; equal only to itself.

    every_tick: whether every tick of the plant has one; others may be slower. parts: numbers of its messages that
    need not be there, each beside a field ``PART_valid``.
    """

    name: str
    type_name: str
    text: str
    rate: float
    ends: Ends = quality.SENSOR
    every_tick: bool = True
    parts: tuple[str, ...] = ()

    @property
    def publisher(self) -> Quality:
        """What its publishers offer."""
        return self.ends.publisher

    @property
    def subscriber(self) -> Quality:
        """What its subscribers ask for."""
        return self.ends.subscriber

    @cached_property
    def type(self) -> type[Any]:
        """Class of its messages; raises `ImportError` where there is no ROS."""
        package, _, name = self.type_name.split("/")
        found: type[Any] = getattr(import_module(f"{package}.msg"), name)
        return found

    @cached_property
    def numbers(self) -> tuple[str, ...]:
        """Fields of its messages that are numbers with a unit."""
        kinds = self.type.get_fields_and_field_types()
        return tuple(field for field, kind in kinds.items() if kind == "double")

    def lacking(self, message: Any) -> str:
        """The first part that a message comes without; empty where it is whole."""
        for part in self.parts:
            if not getattr(message, f"{part}_valid"):
                return part
        return ""


def _ours(name: str, message: str, text: str, ends: Ends = quality.SENSOR) -> Topic:
    """A topic of every tick with a message of er_damper_msgs."""
    return Topic(name, f"er_damper_msgs/msg/{message}", text, SAMPLE_RATE, ends)


ACCELERATION: Final = _ours(
    "sensors/acceleration", "SuspensionAcceleration", "sprung and unsprung acceleration [m/s2]"
)
DEFLECTION: Final = replace(
    _ours("sensors/deflection", "SuspensionDeflection", "deflection [m] and its velocity [m/s]"),
    parts=("velocity",),
)
FORCE: Final = _ours("sensors/force", "DamperForce", "measured damper force [N]")
ROAD: Final = _ours("sensors/road", "RoadDisplacement", "road displacement [m]")
PWM_APPLIED: Final = _ours("pwm/applied", "PwmDuty", "duty after all limits [1]")
PWM_COMMAND: Final = _ours("pwm/command", "PwmDuty", "duty asked for [1]", quality.COMMAND)
FAULT: Final = replace(
    _ours("fault/estimate", "FaultEstimate", "effectiveness f1, f2, f3 [1]"), every_tick=False
)
MODEL_FORCE: Final = _ours("model/force", "DamperForce", "damper force of the model [N]")
MODEL_RESIDUAL: Final = _ours(
    "model/residual", "DamperForce", "measured force less that of the model [N]"
)
STATUS: Final = Topic(
    "~/status", "er_damper_msgs/msg/NodeStatus", "health of the node", 10.0, quality.STATUS
)
RECORDED: Final = Topic(
    "~/recorded",
    "diagnostic_msgs/msg/DiagnosticStatus",
    "number of the last message that is written, by topic",
    10.0,
    quality.STATUS,
    every_tick=False,
)
DIAGNOSTICS: Final = Topic(
    "/diagnostics",
    "diagnostic_msgs/msg/DiagnosticArray",
    "health of the node",
    1.0,
    quality.DIAGNOSTICS,
)
CLOCK: Final = Topic(
    "/clock", "rosgraph_msgs/msg/Clock", "simulated time", SAMPLE_RATE, quality.CLOCK
)
BODY_ACCELERATION: Final = Topic(
    "body/acceleration",
    "geometry_msgs/msg/AccelStamped",
    "heave (linear.z) [m/s2], roll and pitch (angular.x, y) [rad/s2] of the body",
    SAMPLE_RATE,
)
BODY_LOAD: Final = Topic(
    "body/load",
    "geometry_msgs/msg/AccelStamped",
    "acceleration of the car forward and left (linear.x, y) by braking and cornering [m/s2]",
    SAMPLE_RATE,
    every_tick=False,
)

SENSORS: Final = (ACCELERATION, DEFLECTION, FORCE, ROAD, PWM_APPLIED)
"""What the plant says, or the bridge to a rig."""
MEASUREMENTS: Final = (ACCELERATION, DEFLECTION, FORCE, ROAD, PWM_COMMAND, PWM_APPLIED)
"""What a recording needs to compare a model with a measurement."""


ESTIMATED: Final = "force/"
"""What the names of estimated forces begin with."""


@cache
def estimated_force(observer: str) -> Topic:
    """The damper force that an observer says; the same object whenever it is asked for."""
    return _ours(f"{ESTIMATED}{observer}", "DamperForce", f"force of the observer {observer} [N]")


@cache
def below(topic: Topic, corner: str) -> Topic:
    """A topic of a corner of a whole car, `front_left/sensors/force`; the same object whenever it is asked for."""
    return replace(topic, name=f"{corner}/{topic.name}")
