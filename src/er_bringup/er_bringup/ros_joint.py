"""A corner as a joint of ros2_control, on messages: no node, no clock.

`joint_state_topic_hardware_interface` (and its forerunner `topic_based_ros2_control`) speaks sensor_msgs/JointState
in both directions. The joint is the damper: position [m] and velocity [m/s] of the deflection, positive in
extension, effort [N] the damper force, positive resists extension. A command of its effort is a force [N], too: the
inverse of the static damper law makes the duty of it. The duty itself, 0..1, is the position of a joint of its own,
on topics of its own, as the two hardware components of it would mix up the values of joints with other interfaces.
"""

from __future__ import annotations

import math
from copy import copy
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np
from er_common.common_parameters import FramedParameters, oldest_sample, silence
from er_common.parameter_table import param, tuning
from er_common.stamps import StampLimits, StampState, check_stamp
from er_common.topics import Topic
from er_models.constants import SAMPLE_RATE
from er_models.files import load_model
from er_models.static_damper import static_damper
from er_observers.programs import OBSERVERS
from er_ros_common.builders import Tick
from er_ros_common.clock import LAST_STAMP, from_stamp
from er_ros_common.core import Said, When
from sensor_msgs.msg import JointState

from er_common import topics
from er_damper_msgs.msg import DamperForce, PwmDuty, SuspensionDeflection
from er_ros_common import builders

MEASURED = "measured"
STATES: Final = Topic(
    "ros2_control/joint_states",
    "sensor_msgs/msg/JointState",
    "deflection, its velocity, force",
    SAMPLE_RATE,
)
COMMANDS: Final = Topic(
    "ros2_control/joint_commands",
    "sensor_msgs/msg/JointState",
    "force as effort",
    SAMPLE_RATE,
    every_tick=False,
)
DUTY_STATES: Final = Topic(
    "ros2_control/duty_states",
    "sensor_msgs/msg/JointState",
    "applied duty as position",
    SAMPLE_RATE,
)
DUTY_COMMANDS: Final = Topic(
    "ros2_control/duty_commands",
    "sensor_msgs/msg/JointState",
    "duty as position",
    SAMPLE_RATE,
    every_tick=False,
)


@dataclass(frozen=True, kw_only=True)
class JointParameters(FramedParameters):
    """Parameters of the node."""

    joint: str = param(
        "damper", text="name of the joint in the URDF; that of its duty is NAME_duty"
    )
    model_file: str = param(
        "", text="model of the damper, for commands of a force; empty: they are refused"
    )
    force_topic: str = param(
        MEASURED,
        choices=(MEASURED, *OBSERVERS),
        text="force that is reported as effort: the measured one (rig) or an observer's (car)",
    )
    timeout: float = tuning(
        0.05, unit="s", low=0.005, high=1.0,
        text="silence of the samples after which commands are refused; "
        "greatest age of a command that has a stamp, and of the force that joins a sample",
    )  # fmt: skip
    max_age: float = oldest_sample()


class State(NamedTuple):
    """What is known, and what was refused.

    x, v: deflection [m] of the last sample and its velocity [m/s], NaN where it is not known;
    force: the last [N], with its stamp [ns]; stamps: checks of those of the samples; last: the last sample, with
    stamp 0 before the first, heard: when it came [ns, steady]; lacks: what its joint state did not hold;
    unusable: samples, refused: commands.
    """

    x: float = 0.0
    v: float = math.nan
    force: float = 0.0
    force_stamp: int = 0
    stamps: StampState = StampState()
    last: Tick = Tick(0, 0)
    heard: int = 0
    lacks: tuple[str, ...] = ()
    unusable: int = 0
    refused: int = 0


class JointCore:
    """Deflection and force in, joint state out; joint command in, duty out.

    A joint state holds what is known and nothing else: without a usable deflection there is none, and `velocity` or
    `effort` are empty where theirs is not valid, not finite or not of the same time.
    """

    outputs = (STATES, DUTY_STATES, topics.PWM_COMMAND)
    commands = (COMMANDS, DUTY_COMMANDS)

    def __init__(self, p: JointParameters) -> None:
        self.p = p
        measured = p.force_topic == MEASURED
        self.force = topics.FORCE if measured else topics.estimated_force(p.force_topic)
        self.inputs = (topics.DEFLECTION, self.force, topics.PWM_APPLIED)
        self.damper = static_damper(load_model(p.model_file)) if p.model_file else None
        self.limits = StampLimits(stale=p.max_age)

    def tuned(self, p: JointParameters) -> JointCore:
        """With another patience; the model is not read again."""
        made = copy(self)
        made.p = p
        return made

    def start(self) -> State:
        """Before any message."""
        return State()

    def on_message(
        self, state: State, topic: Topic, message: Any, when: When
    ) -> tuple[State, list[Said]]:
        """Take a message; what is not usable is not passed on."""
        if topic in self.commands:
            return self._commanded(state, topic, message, when)
        if topic is topics.PWM_APPLIED:
            return self._applied(state, message)
        if topic is self.force:
            return self._forced(state, message), []
        return self._sampled(state, message, when)

    def on_time(self, state: State, _: When) -> tuple[State, list[Said]]:
        """Nothing: without commands nothing is commanded, and the plant goes to its safe duty."""
        return state, []

    def silent(self, state: State, steady: int) -> bool:
        """Whether usable samples stay away, at a time on the steady clock [ns]."""
        return silence(self.p, steady - state.heard) > self.p.timeout

    def _forced(self, state: State, message: DamperForce) -> State:
        """The force, until a sample comes that is too far away."""
        if not (message.valid and math.isfinite(message.force)):
            return state
        return state._replace(force=message.force, force_stamp=from_stamp(message.header.stamp))

    def _applied(self, state: State, message: PwmDuty) -> tuple[State, list[Said]]:
        """The state of the duty's joint."""
        stamp = from_stamp(message.header.stamp)
        if not (message.valid and math.isfinite(message.duty) and stamp < LAST_STAMP):
            return state, []
        joint = JointState(header=message.header, name=[f"{self.p.joint}_duty"])
        joint.position = [float(message.duty)]
        return state, [(DUTY_STATES, joint)]

    def _sampled(
        self, state: State, message: SuspensionDeflection, when: When
    ) -> tuple[State, list[Said]]:
        """The joint state of a deflection, as far as it is known."""
        stamp = from_stamp(message.header.stamp)
        sound = message.valid and math.isfinite(message.deflection) and stamp < LAST_STAMP
        if not sound:
            return state._replace(unusable=state.unusable + 1), []
        arrival = when.system if self.p.max_age else None
        stamps, verdict = check_stamp(self.limits, state.stamps, stamp, int(message.seq), arrival)
        state = state._replace(stamps=stamps)
        if not verdict.use:
            return state, []
        velocity = [message.velocity] if message.velocity_valid else []
        apart = 1e-9 * abs(stamp - state.force_stamp)
        effort = [state.force] if state.force_stamp > 0 and apart <= self.p.timeout else []
        joint = JointState(header=message.header, name=[self.p.joint])
        joint.position = [float(message.deflection)]
        joint.velocity = [float(each) for each in velocity if math.isfinite(each)]
        joint.effort = [float(each) for each in effort]
        parts = {"velocity": joint.velocity, self.force.name: joint.effort}
        lacks = tuple(name for name, part in parts.items() if not part)
        last = Tick(stamp, int(message.seq))
        v = joint.velocity[0] if joint.velocity else math.nan
        state = state._replace(last=last, heard=when.steady, lacks=lacks, x=joint.position[0], v=v)
        return state, [(STATES, joint)]

    def _duty(self, state: State, topic: Topic, message: JointState) -> float:
        """The duty of a command; NaN where it says none, or a force that no duty can be computed of."""
        if topic is DUTY_COMMANDS:
            positions = dict(zip(message.name, message.position, strict=False))
            return float(positions.get(f"{self.p.joint}_duty", math.nan))
        force = dict(zip(message.name, message.effort, strict=False)).get(self.p.joint, math.nan)
        if self.damper is None or not math.isfinite(force + state.v):
            return math.nan
        # what no duty can make gets the nearest: the least where the force would push
        force, x, v = np.array([[force], [state.x], [state.v]])
        found = self.damper.duty_for(force, x, v, (0.0, 1.0))
        return float(found.duty[0])

    def _commanded(
        self, state: State, topic: Topic, message: JointState, when: When
    ) -> tuple[State, list[Said]]:
        """The duty of a joint command, as answer to the last sample; one without a stamp is as new as it is heard."""
        stamp = from_stamp(message.header.stamp)
        arrival = when.system if self.p.max_age and stamp else None
        old = arrival is not None and 1e-9 * (arrival - stamp) > self.p.timeout
        duty = self._duty(state, topic, message)
        useless = old or not math.isfinite(duty)
        if useless or not state.last.stamp or self.silent(state, when.steady):
            return state._replace(refused=state.refused + 1), []
        command = builders.pwm_duty(state.last, duty, source=PwmDuty.SOURCE_NOMINAL)
        command.header.frame_id = self.p.frame_id
        return state, [(topics.PWM_COMMAND, command)]
