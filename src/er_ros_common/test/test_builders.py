"""Builders: nothing of a wrong Python type, nothing that is not finite, gets into a message."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from er_common.stamps import StampState
from rclpy.serialization import deserialize_message, serialize_message

from er_damper_msgs.msg import FaultEstimate, NodeStatus, PwmDuty
from er_ros_common import builders as b

TICK = b.Tick(stamp=12_000_000_345, seq=7)
HEALTHY = (FaultEstimate.FAULT_HEALTHY,) * 3

#: a builder of one number, given that number
ONE_NUMBER: dict[str, Callable[[Any], Any]] = {
    "sprung": lambda v: b.suspension_acceleration(TICK, v, 0.5),
    "unsprung": lambda v: b.suspension_acceleration(TICK, 0.5, v),
    "deflection": lambda v: b.suspension_deflection(TICK, v, 0.5),
    "velocity": lambda v: b.suspension_deflection(TICK, 0.5, v),
    "force": lambda v: b.damper_force(TICK, v),
    "force_sd": lambda v: b.damper_force(TICK, 0.5, force_sd=v),
    "test_ratio": lambda v: b.damper_force(TICK, 0.5, test_ratio=v),
    "displacement": lambda v: b.road_displacement(TICK, v),
    "duty": lambda v: b.pwm_duty(TICK, v),
    "f2": lambda v: b.fault_estimate(TICK, (1.0, v, 1.0), (0.1, 0.1, 0.1), HEALTHY),
    "certainty": lambda v: b.fault_estimate(TICK, (1, 1, 1), (0, 0, 0), HEALTHY, certainty=v),
    "residual": lambda v: b.fault_estimate(TICK, (1, 1, 1), (0, 0, 0), HEALTHY, residual=v),
    "f3_sd": lambda v: b.fault_estimate(TICK, (1.0, 1.0, 1.0), (0.1, 0.1, v), HEALTHY),
    "output_rate": lambda v: b.node_status(TICK, "/n", "run", timing=b.Timing(output_rate=v)),
}


@pytest.mark.parametrize("name", ONE_NUMBER)
@pytest.mark.parametrize("value", [1, np.float32(1.0), np.float64(1.0), np.int64(1)])
def test_any_real_number_arrives_as_itself(name: str, value: Any) -> None:
    message = ONE_NUMBER[name](value)
    back = deserialize_message(serialize_message(message), type(message))
    assert getattr(back, name) == 1.0
    assert type(getattr(message, name)) is float
    assert back.valid
    assert (back.header.stamp.sec, back.header.stamp.nanosec) == (12, 345)
    assert back.seq == 7


@pytest.mark.parametrize("name", ONE_NUMBER)
@pytest.mark.parametrize("value", ["1.0", b"1", True, 1j, [1.0], np.array([1.0])])
def test_anything_else_is_a_type_error_naming_the_field(name: str, value: Any) -> None:
    with pytest.raises(TypeError, match=f"^{name} must be a number"):
        ONE_NUMBER[name](value)


@pytest.mark.parametrize("name", [n for n in ONE_NUMBER if n != "velocity"])
def test_none_is_a_type_error(name: str) -> None:
    with pytest.raises(TypeError, match=f"^{name} must be a number, not NoneType"):
        ONE_NUMBER[name](None)


@pytest.mark.parametrize("name", ONE_NUMBER)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_nothing_that_is_not_finite_travels(name: str, value: float) -> None:
    message = ONE_NUMBER[name](value)
    assert not message.valid
    assert message.status == message.STATUS_FAULT
    fields = message.get_fields_and_field_types()
    numbers = [getattr(message, n) for n, kind in fields.items() if kind == "double"]
    assert numbers
    assert all(number == 0.0 for number in numbers)


def test_velocity_that_is_not_measured_says_so() -> None:
    without, measured = (
        b.suspension_deflection(TICK, 0.01),
        b.suspension_deflection(TICK, 0.01, 0.2),
    )
    assert (without.velocity, without.velocity_valid, without.valid) == (0.0, False, True)
    assert (measured.velocity, measured.velocity_valid) == (0.2, True)


@pytest.mark.parametrize(("asked", "sent"), [(-0.1, 0.0), (1.2, 1.0)])
def test_duty_never_leaves_its_range(asked: float, sent: float) -> None:
    message = b.pwm_duty(TICK, asked, source=PwmDuty.SOURCE_NOMINAL)
    assert (message.duty, message.saturated) == (sent, True)
    assert not b.pwm_duty(TICK, sent).saturated


def test_command_carries_its_own_sequence_number_and_applied_that_of_the_command() -> None:
    assert b.pwm_duty(TICK, 0.1).command_seq == 7
    assert b.pwm_duty(TICK, 0.1, command_seq=5).command_seq == 5


@pytest.mark.parametrize(
    ("field", "build"),
    [
        ("seq", lambda v: b.damper_force(b.Tick(1, v), 1.0)),
        ("status", lambda v: b.damper_force(TICK, 1.0, status=v)),
        ("source", lambda v: b.pwm_duty(TICK, 0.1, source=v)),
        ("command_seq", lambda v: b.pwm_duty(TICK, 0.1, command_seq=v)),
        ("f2_status", lambda v: b.fault_estimate(TICK, (1, 1, 1), (0, 0, 0), (1, v, 1))),
        ("kind", lambda v: b.fault_estimate(TICK, (1, 1, 1), (0, 0, 0), HEALTHY, kind=v)),
        ("non_finite", lambda v: b.node_status(TICK, "/n", "run", non_finite=v)),
    ],
)
def test_integers_are_integers_in_range(field: str, build: Callable[[Any], Any]) -> None:
    assert getattr(build(np.uint8(3)), field) == 3
    for wrong in (1.0, "1", True):
        with pytest.raises(TypeError, match=f"^{field} must be an integer"):
            build(wrong)
    with pytest.raises(ValueError, match=f"^{field} must be in"):
        build(-1)


@pytest.mark.parametrize("wrong", [1, "yes", 0.0])
def test_truth_values_are_truth_values(wrong: Any) -> None:
    with pytest.raises(TypeError, match="valid must be true or false"):
        b.damper_force(TICK, 1.0, valid=wrong)
    assert b.damper_force(TICK, 1.0, valid=np.bool_(True)).valid is True


def test_fault_estimate_needs_three_of_each() -> None:
    with pytest.raises(ValueError, match="three factors"):
        b.fault_estimate(TICK, (1.0, 1.0), (0.0, 0.0), (1, 1))


def test_node_status_carries_the_counts() -> None:
    stamps = StampState(received=5, used=4, lost=2, duplicate=1, zero_stamp=3, resets=6)
    message = b.node_status(
        TICK, "/fl/plant", "running", stamps=stamps, reason="late", valid=False
    )
    assert isinstance(message, NodeStatus)
    found = (message.received, message.used, message.lost, message.duplicate)
    assert found == (5, 4, 2, 1)
    assert (message.zero_stamp, message.resets, message.reason) == (3, 6, "late")
    assert not message.valid


def test_texts_are_texts() -> None:
    with pytest.raises(TypeError, match="mode must be a text"):
        b.node_status(TICK, "/n", 3)  # type: ignore[arg-type]


def test_message_of_a_stream_has_a_constant_size() -> None:
    sizes = {
        len(serialize_message(b.damper_force(b.Tick(stamp, seq), force)))
        for stamp, seq, force in ((1, 1, 0.0), (10**18, 2**63, -1e300))
    }
    assert len(sizes) == 1
