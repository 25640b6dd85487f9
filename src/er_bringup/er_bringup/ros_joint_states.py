"""The joint of a strut as `sensors/deflection`, on messages: no node, no clock.

`joint_state_broadcaster` of ros2_control says it as `sensor_msgs/JointState` and `control_msgs/DynamicJointState`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

from er_common.common_parameters import NodeParameters, oldest_sample
from er_common.parameter_table import param, tuning
from er_common.stamps import StampLimits, StampState
from er_common.topics import Topic
from er_models.constants import SAMPLE_RATE
from er_models.errors import InputError
from er_ros_common.builders import Tick
from er_ros_common.clock import LAST_STAMP, from_stamp
from er_ros_common.core import Said, When

from er_bringup.ros_foreign import Foreign
from er_common import topics
from er_damper_msgs.msg import SuspensionDeflection
from er_ros_common import builders

STATES: Final = Topic(
    "joint_states", "sensor_msgs/msg/JointState", "position and velocity of joints", SAMPLE_RATE
)
DYNAMIC_STATES: Final = Topic(
    "dynamic_joint_states",
    "control_msgs/msg/DynamicJointState",
    "interfaces of joints, position and velocity among them",
    SAMPLE_RATE,
)


@dataclass(frozen=True, kw_only=True)
class JointStateParameters(NodeParameters):
    """Parameters of both adapters."""

    joint: str = param("damper", text="name of the joint in the messages")
    ratio: float = tuning(
        1.0,
        low=-10.0,
        high=10.0,
        text="deflection [m], positive in extension, per position of the joint [m or rad]; never 0",
    )
    zero: float = tuning(
        0.0, low=-100.0, high=100.0, text="position of the joint at deflection zero [m or rad]"
    )
    timeout: float = tuning(
        0.05, unit="s", low=0.005, high=1.0, text="silence of the joint that is told as lost"
    )
    max_age: float = oldest_sample()


class State(NamedTuple):
    """Checks of stamps, samples of the joint, and what came of them; others: messages without the joint."""

    stamps: StampState = StampState()
    number: int = 0
    last: Tick = Tick(0, 0)
    heard: int = 0
    invalid: int = 0
    others: int = 0


class JointStateCore(Foreign):
    """States of joints in, the deflection of one of them out, with the stamp and frame of the message."""

    output = topics.DEFLECTION
    awaited = "state of the joint"

    def __init__(self, p: JointStateParameters, states: Topic) -> None:
        if not p.ratio:
            raise InputError("parameters", "ratio", "a number other than 0", "0")
        self.p = p
        self.inputs: tuple[Topic, ...] = (states,)
        self.limits = StampLimits(stale=p.max_age)

    def start(self) -> State:
        """Before any message."""
        return State()

    def values(self, state: State) -> dict[str, object]:
        """What else it tells of itself."""
        return {"messages without the joint": state.others}

    def on_message(
        self, state: State, _: Topic, message: Any, when: When, /
    ) -> tuple[State, list[Said]]:
        """Take the states of some joints; they need not hold ours, as several may publish some."""
        found = interfaces(message, self.p.joint)
        if found is None:
            return state._replace(others=state.others + 1), []
        stamp = from_stamp(message.header.stamp)
        if stamp >= LAST_STAMP:
            return state._replace(invalid=state.invalid + 1), []
        state, verdict = self.counted(state, stamp, when)
        if not verdict.use:
            return state, []
        said = self._deflection(Tick(stamp, state.number), found)
        said.header.frame_id = message.header.frame_id
        invalid = state.invalid + (not said.valid)
        state = state._replace(last=Tick(stamp, state.number), heard=when.steady, invalid=invalid)
        return state, [(topics.DEFLECTION, said)]

    def _deflection(self, tick: Tick, found: dict[str, float]) -> SuspensionDeflection:
        """Not valid without a finite position; without a finite velocity its part is not there."""
        x = self.p.ratio * (found.get("position", math.nan) - self.p.zero)
        v = self.p.ratio * found.get("velocity", math.nan)
        return builders.suspension_deflection(tick, x, v if math.isfinite(v) else None)


def interfaces(message: Any, joint: str) -> dict[str, float] | None:
    """What either message holds of a joint, by the interface's name; None where it does not hold the joint."""
    dynamic = hasattr(message, "joint_names")
    names = list(message.joint_names if dynamic else message.name)
    if joint not in names:
        return None
    k = names.index(joint)
    if not dynamic:
        # an array may be empty, or shorter than the names
        columns = {"position": message.position, "velocity": message.velocity}
        return {name: float(column[k]) for name, column in columns.items() if k < len(column)}
    held = message.interface_values[k : k + 1]
    return {
        name: float(value)
        for each in held
        for name, value in zip(each.interface_names, each.values, strict=False)
    }
