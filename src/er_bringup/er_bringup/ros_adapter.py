"""Accelerometers of a vehicle as `sensors/acceleration`, on messages: no node, no clock.

One sensor sits on the body above the strut, one on the wheel carrier; both speak `sensor_msgs/Imu` or
`geometry_msgs/AccelStamped`.
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
from er_ros_common.builders import Tick
from er_ros_common.clock import LAST_STAMP, from_stamp
from er_ros_common.core import Said, When

from er_bringup.mounting import GRAVITY, Vector, upward, upward_of, vertical
from er_bringup.ros_foreign import Foreign
from er_common import topics
from er_damper_msgs.msg import SuspensionAcceleration
from er_ros_common import builders

SIDES: Final = ("sprung", "unsprung")


def inputs(folder: str, type_name: str) -> tuple[Topic, ...]:
    """The two sensors of a corner."""
    text = "acceleration of the {} mass, in the sensor's axes"
    return tuple(
        Topic(f"{folder}/{side}", type_name, text.format(side), SAMPLE_RATE) for side in SIDES
    )


IMU: Final = inputs("imu", "sensor_msgs/msg/Imu")
ACCEL: Final = inputs("accel", "geometry_msgs/msg/AccelStamped")


def _turned(side: str) -> Any:
    text = f"roll, pitch and yaw of the sensor on the {side} mass, about x, y, z of the vehicle"
    return param(
        (0.0, 0.0, 0.0),
        unit="rad",
        length=3,
        low=-math.tau,
        high=math.tau,
        name=f"mounting.{side}",
        text=text,
    )


@dataclass(frozen=True, kw_only=True)
class AdapterParameters(NodeParameters):
    """Parameters of both adapters."""

    mounting_sprung: tuple[float, ...] = _turned("sprung")
    mounting_unsprung: tuple[float, ...] = _turned("unsprung")
    gravity: float = tuning(
        0.0,
        unit="m/s2",
        low=0.0,
        high=20.0,
        text="what the sensors read upwards at rest; 0: it is taken away already",
    )
    apart: float = tuning(
        0.0025,
        unit="s",
        low=0.0,
        high=0.1,
        text="most time between the stamps of two samples that make one",
    )
    timeout: float = tuning(
        0.05, unit="s", low=0.005, high=1.0, text="silence of the samples that is told as lost"
    )
    max_age: float = oldest_sample()


@dataclass(frozen=True, kw_only=True)
class ImuParameters(AdapterParameters):
    """Parameters of the adapter of Imu messages."""

    gravity: float = tuning(
        GRAVITY,
        unit="m/s2",
        low=0.0,
        high=20.0,
        text="what the sensors read upwards at rest (REP-145); 0: taken away",
    )
    use_orientation: bool = param(
        False,
        text="take the vertical from the orientation of the messages; one without it is not valid",
    )


class Sample(NamedTuple):
    """What one sensor said: stamp [ns], frame, vertical acceleration [m/s2], NaN where it is of no use."""

    stamp: int
    frame: str
    value: float


class State(NamedTuple):
    """What waits for its other half, checks of the body's stamps, samples of the body, and what came of them."""

    waiting: tuple[Sample | None, Sample | None] = (None, None)
    stamps: StampState = StampState()
    number: int = 0
    last: Tick = Tick(0, 0)
    heard: int = 0
    invalid: int = 0
    alone: int = 0


class AdapterCore(Foreign):
    """Two accelerometers in, the accelerations of a corner out, with the stamp of the body's."""

    output = topics.ACCELERATION
    awaited = "pair of samples"

    def __init__(self, p: AdapterParameters, sensors: tuple[Topic, ...]) -> None:
        self.p, self.inputs = p, sensors
        self.limits = StampLimits(stale=p.max_age)
        turned = (p.mounting_sprung, p.mounting_unsprung)
        self.up = [upward(roll, pitch) for roll, pitch, _ in turned]
        self.asked = isinstance(p, ImuParameters) and p.use_orientation

    def start(self) -> State:
        """Before any message."""
        return State()

    def values(self, state: State) -> dict[str, object]:
        """What else it tells of itself."""
        return {"samples without their other half": state.alone}

    def on_message(
        self, state: State, topic: Topic, message: Any, when: When
    ) -> tuple[State, list[Said]]:
        """Take a sample of one sensor; with its other half it is published."""
        side, stamp = self.inputs.index(topic), from_stamp(message.header.stamp)
        if stamp >= LAST_STAMP:
            return state._replace(invalid=state.invalid + 1), []
        if side == 0:
            state, verdict = self.counted(state, stamp, when)
            if not verdict.use:
                return state, []
        own = Sample(stamp, message.header.frame_id, self._vertical(side, message))
        other = state.waiting[1 - side]
        if other is None or 1e-9 * abs(other.stamp - stamp) > self.p.apart:
            # the older of two that are too far apart has missed its other half
            alone = (state.waiting[side] is not None) + (other is not None and other.stamp < stamp)
            kept = None if other is None or other.stamp < stamp else other
            pair = (own, kept) if side == 0 else (kept, own)
            return state._replace(waiting=pair, alone=state.alone + alone), []
        body, wheel = (own, other) if side == 0 else (other, own)
        return self._joined(state, body, wheel, when)

    def _vertical(self, side: int, message: Any) -> float:
        """What a message says of the vertical [m/s2]; NaN where it cannot be told."""
        if not hasattr(message, "orientation"):
            read, up = message.accel.linear, self.up[side]
        else:
            read, q = message.linear_acceleration, message.orientation
            known = message.orientation_covariance[0] >= 0.0  # REP-145: -1 where there is none
            turned = upward_of(q.x, q.y, q.z, q.w) if known else None
            if message.linear_acceleration_covariance[0] < 0.0 or (self.asked and turned is None):
                return math.nan
            up = turned if self.asked and turned is not None else self.up[side]
        return vertical(Vector(read.x, read.y, read.z), up, self.p.gravity)

    def _joined(
        self, state: State, body: Sample, wheel: Sample, when: When
    ) -> tuple[State, list[Said]]:
        """Both halves as one message; not valid where one of them is no number."""
        good = math.isfinite(body.value) and math.isfinite(wheel.value)
        tick, values = (
            Tick(body.stamp, state.number),
            (body.value, wheel.value) if good else (0.0, 0.0),
        )
        status = SuspensionAcceleration.STATUS_OK if good else SuspensionAcceleration.STATUS_FAULT
        message = builders.suspension_acceleration(tick, *values, status=status, valid=good)
        message.header.frame_id = body.frame
        state = state._replace(
            waiting=(None, None), last=tick, heard=when.steady, invalid=state.invalid + (not good)
        )
        return state, [(topics.ACCELERATION, message)]
