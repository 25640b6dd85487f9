r"""Autoware's velocity report of a vehicle as `body/load`, on messages: no node, no clock.

`autoware_vehicle_msgs/VelocityReport` tells the velocity v_x forward and v_y to the left, and the heading rate r. The
body feels the acceleration of the car in its own axes, which turn:

.. math::  a_x = \dot v_x - r v_y, \qquad a_y = \dot v_y + r v_x .

The derivatives are differences of the reports through a first-order low-pass.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

from er_common.common_parameters import NodeParameters, oldest_sample
from er_common.parameter_table import tuning
from er_common.stamps import StampLimits, StampState
from er_common.topics import Topic
from er_ros_common.builders import Tick
from er_ros_common.clock import LAST_STAMP, from_stamp
from er_ros_common.core import Said, When
from geometry_msgs.msg import AccelStamped

from er_bringup.ros_foreign import Foreign
from er_common import topics

REPORT: Final = Topic(
    "vehicle/status/velocity_status",
    "autoware_vehicle_msgs/msg/VelocityReport",
    "velocity forward and to the left [m/s], heading rate [rad/s]",
    50.0,
    every_tick=False,
)


@dataclass(frozen=True, kw_only=True)
class AutowareParameters(NodeParameters):
    """Parameters of the node."""

    smoothing: float = tuning(
        0.1, unit="s", low=0.0, high=5.0, text="time constant of the low-pass on accelerations"
    )
    timeout: float = tuning(
        0.2,
        unit="s",
        low=0.005,
        high=5.0,
        text="silence of the reports that is told as lost; after a longer gap differences begin anew",
    )
    max_age: float = oldest_sample()


class State(NamedTuple):
    """The last report and what came of it.

    v_x, v_y: its velocities [m/s]; a_x, a_y: their smoothed derivatives [m/s2]; stamp: its own [ns], 0 before the
    first; stamps: checks of those of all; number: reports; last: the last one published; heard: when, on the steady
    clock [ns]; invalid: reports of no use.
    """

    v_x: float = 0.0
    v_y: float = 0.0
    a_x: float = 0.0
    a_y: float = 0.0
    stamp: int = 0
    stamps: StampState = StampState()
    number: int = 0
    last: Tick = Tick(0, 0)
    heard: int = 0
    invalid: int = 0


class AutowareCore(Foreign):
    """Velocity reports in, accelerations of the car out, with the stamp and frame of the report."""

    inputs: tuple[Topic, ...] = (REPORT,)
    output = topics.BODY_LOAD
    awaited = "two reports of the velocity"

    def __init__(self, p: AutowareParameters) -> None:
        self.p = p
        self.limits = StampLimits(stale=p.max_age, gap=p.timeout)

    def start(self) -> State:
        """Before any message."""
        return State()

    def values(self, state: State) -> dict[str, object]:
        """What else it tells of itself."""
        return {"acceleration forward, left [m/s2]": f"{state.a_x:.2f}, {state.a_y:.2f}"}

    def on_message(
        self, state: State, _: Topic, message: Any, when: When, /
    ) -> tuple[State, list[Said]]:
        """Take a report; from the second one on the load is published."""
        stamp = from_stamp(message.header.stamp)
        v_x, v_y = float(message.longitudinal_velocity), float(message.lateral_velocity)
        turning = float(message.heading_rate)
        if stamp >= LAST_STAMP or not math.isfinite(v_x + v_y + turning):
            return state._replace(invalid=state.invalid + 1), []
        state, verdict = self.counted(state, stamp, when)
        if not verdict.use:
            return state, []
        if verdict.restart:
            return state._replace(v_x=v_x, v_y=v_y, a_x=0.0, a_y=0.0, stamp=stamp), []
        state = self._moved(state, v_x, v_y, stamp)._replace(
            last=Tick(stamp, state.number), heard=when.steady
        )
        load = AccelStamped(header=message.header)
        load.accel.linear.x = state.a_x - turning * v_y
        load.accel.linear.y = state.a_y + turning * v_x
        return state, [(topics.BODY_LOAD, load)]

    def _moved(self, state: State, v_x: float, v_y: float, stamp: int) -> State:
        """With the derivatives up to this report."""
        dt = 1e-9 * (stamp - state.stamp)
        share = 1.0 - math.exp(-dt / self.p.smoothing) if self.p.smoothing else 1.0
        a_x = state.a_x + share * ((v_x - state.v_x) / dt - state.a_x)
        a_y = state.a_y + share * ((v_y - state.v_y) / dt - state.a_y)
        return state._replace(v_x=v_x, v_y=v_y, a_x=a_x, a_y=a_y, stamp=stamp)
