"""A corner as a joint of ros2_control, on messages: no node, no clock.

`joint_state_topic_hardware_interface` (and its forerunner `topic_based_ros2_control`) speaks sensor_msgs/JointState
in both directions. The joint is the damper: position [m] and velocity [m/s] of the deflection, positive in
extension, effort [N] the damper force, positive resists extension. The command interface is `effort` too, the
only one that is neither position nor velocity, and carries the duty, 0..1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

from er_ros_common.builders import Tick
from er_ros_common.clock import from_stamp
from er_ros_common.common_parameters import NodeParameters
from er_ros_common.core import Said, When
from er_ros_common.parameter_table import param
from er_ros_common.topics import Topic
from sensor_msgs.msg import JointState

from er_damper_msgs.msg import PwmDuty
from er_ros_common import builders, qos, topics

STATES: Final = Topic(
    "ros2_control/joint_states",
    JointState,
    "deflection, its velocity, force",
    200.0,
    qos.SENSOR_PUBLISHER,
    qos.SENSOR_SUBSCRIBER,
)
COMMANDS: Final = Topic(
    "ros2_control/joint_commands",
    JointState,
    "duty as effort",
    200.0,
    qos.SENSOR_PUBLISHER,
    qos.SENSOR_SUBSCRIBER,
    every_tick=False,
)


@dataclass(frozen=True, kw_only=True)
class JointParameters(NodeParameters):
    """Parameters of the node."""

    joint: str = param("damper", text="name of the joint in the URDF")
    force_topic: str = param(
        "measured",
        choices=("measured", "unified", "nlpv_polytopic", "nlpv_gridding"),
        text="force that is the effort: measured on a rig, estimated in a car",
    )


class State(NamedTuple):
    """The last force [N] and the last sample; commands that were refused."""

    force: float = 0.0
    last: Tick = Tick(0, 0)
    refused: int = 0


class JointCore:
    """Deflection and force in, joint state out; joint command in, duty out."""

    outputs = (STATES, topics.PWM_COMMAND)

    def __init__(self, p: JointParameters) -> None:
        self.p = p
        estimates = {topic.name.rpartition("/")[2]: topic for topic in topics.ESTIMATES}
        self.force = estimates.get(p.force_topic, topics.FORCE)
        self.inputs = (topics.DEFLECTION, self.force, COMMANDS)

    def start(self) -> State:
        """Before any message."""
        return State()

    def on_message(
        self, state: State, topic: Topic, message: Any, _: When
    ) -> tuple[State, list[Said]]:
        """Take a message; what is not valid is not passed on."""
        if topic is COMMANDS:
            return self._commanded(state, message)
        if not message.valid:
            return state, []
        if topic is self.force:
            return state._replace(force=message.force), []
        last = Tick(from_stamp(message.header.stamp), int(message.seq))
        joint = JointState(header=message.header, name=[self.p.joint])
        joint.position = [float(message.deflection)]
        joint.velocity = [float(message.velocity)]
        joint.effort = [float(state.force)]
        return state._replace(last=last), [(STATES, joint)]

    def on_time(self, state: State, _: When) -> tuple[State, list[Said]]:
        """Nothing: without commands nothing is commanded, and the plant goes to its safe duty."""
        return state, []

    def _commanded(self, state: State, message: JointState) -> tuple[State, list[Said]]:
        """The duty of a joint command, as answer to the last sample."""
        efforts = dict(zip(message.name, message.effort, strict=False))
        duty = efforts.get(self.p.joint, math.nan)
        if not math.isfinite(duty) or not state.last.seq:
            return state._replace(refused=state.refused + 1), []
        command = builders.pwm_duty(state.last, duty, source=PwmDuty.SOURCE_NOMINAL)
        return state, [(topics.PWM_COMMAND, command)]
