"""Accelerometers of a vehicle: turned, with gravity, joined by their stamps."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import replace
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy")

from er_bringup.mounting import GRAVITY, Vector, upward, upward_of, vertical
from er_bringup.ros_adapter import ACCEL, IMU, AdapterCore, AdapterParameters, ImuParameters
from er_ros_common.clock import to_stamp
from er_ros_common.core import When
from geometry_msgs.msg import AccelStamped
from sensor_msgs.msg import Imu

MS = 1_000_000
T0 = 1_000_000 * MS
NOW = When(0, None)


def turn(roll: float, pitch: float, yaw: float) -> Any:
    """Rotation matrix of the sensor's axes in the vehicle's, by its three factors."""
    (cr, cp, cy), (sr, sp, sy) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return z @ y @ x


def quaternion(matrix: Any) -> tuple[float, float, float, float]:
    """Of a rotation by less than half a turn."""
    w = 0.5 * math.sqrt(1.0 + np.trace(matrix))
    skew = (matrix - matrix.T) / (4.0 * w)
    return skew[2, 1], skew[0, 2], skew[1, 0], w


@pytest.mark.parametrize(
    "angles", [(0, 0, 0), (0.3, -0.4, 1.1), (math.pi, 0, 0), (0, math.pi / 2, 0)]
)
def test_what_a_turned_sensor_reads_is_turned_back(angles: tuple[float, float, float]) -> None:
    up, motion = np.array([0.0, 0.0, 1.0]), 2.5
    read = Vector(*(turn(*angles).T @ (up * (motion + GRAVITY) + [0.7, -0.3, 0.0])))
    assert vertical(read, upward(*angles[:2]), GRAVITY) == pytest.approx(motion)
    if max(angles) < 3.0:
        found = upward_of(*quaternion(turn(*angles)))
        assert found == pytest.approx(upward(*angles[:2]))


def test_an_orientation_that_is_no_rotation_is_none() -> None:
    assert upward_of(0.0, 0.0, 0.0, 0.0) is None
    assert upward_of(math.nan, 0.0, 0.0, 1.0) is None


def imu(stamp: int, x: float, y: float, z: float, **covariance: Any) -> Imu:
    message = Imu(**covariance)
    message.header.stamp, message.header.frame_id = to_stamp(stamp), "strut"
    message.linear_acceleration.x, message.linear_acceleration.y = x, y
    message.linear_acceleration.z = z
    return message


def fed(core: AdapterCore, *given: tuple[int, Any]) -> tuple[Any, list[Any]]:
    """State and messages after samples of (side, message)."""
    state, out = core.start(), []
    for side, message in given:
        state, said = core.on_message(state, core.inputs[side], message, NOW)
        out += [each for _, each in said]
    return state, out


P = ImuParameters(max_age=0.0, mounting_unsprung=(0.0, math.pi / 2, 0.0))


def test_both_sensors_make_one_message_with_the_stamp_of_the_body() -> None:
    core = AdapterCore(P, IMU)
    state, out = fed(
        core,
        (0, imu(T0, 0.0, 0.0, GRAVITY + 1.5)),
        (1, imu(T0 + MS, -(GRAVITY - 2.0), 0.0, 0.0)),
        (1, imu(T0 + 5 * MS, -GRAVITY, 0.0, 0.0)),
        (0, imu(T0 + 6 * MS, 0.0, 0.0, GRAVITY)),
    )
    assert [(m.sprung, m.unsprung) for m in out] == [
        pytest.approx((1.5, -2.0)),
        pytest.approx((0.0, 0.0), abs=1e-9),
    ]
    assert [m.header.stamp for m in out] == [to_stamp(T0), to_stamp(T0 + 6 * MS)]
    assert [(m.seq, m.valid, m.header.frame_id) for m in out] == [
        (1, True, "strut"),
        (2, True, "strut"),
    ]
    assert state.alone == 0


def test_a_sample_that_lost_its_other_half_is_counted_and_leaves_a_gap() -> None:
    good = imu(0, 0.0, 0.0, GRAVITY)
    core = AdapterCore(replace(P, mounting_unsprung=(0.0,) * 3), IMU)

    def at(k: int) -> Imu:
        message = imu(0, 0.0, 0.0, GRAVITY)
        message.header.stamp = to_stamp(T0 + 5 * MS * k)
        return message

    sides = [(0, 1), (1, 1), (0, 2), (0, 3), (1, 3), (1, 4), (1, 5), (0, 5), (0, 5)]
    state, out = fed(
        core,
        *((side, at(k)) for side, k in sides),
        (1, good),
        *((side, at(k)) for side, k in ((1, 6), (0, 7), (1, 7))),
    )
    assert [m.seq for m in out] == [1, 3, 4, 6]
    assert state.alone == 4  # body 2, wheel 4, the one without a stamp, wheel 6
    assert state.stamps.duplicate == 1


@pytest.mark.parametrize(
    "bad",
    [
        imu(T0, 0.0, 0.0, math.nan),
        imu(T0, 0.0, 0.0, GRAVITY, linear_acceleration_covariance=[-1.0] + [0.0] * 8),
    ],
)
def test_a_reading_that_is_none_is_not_valid(bad: Imu) -> None:
    state, (said,) = fed(AdapterCore(P, IMU), (0, bad), (1, imu(T0, 0.0, 0.0, 0.0)))
    assert (said.sprung, said.unsprung, said.valid, said.status) == (
        0.0,
        0.0,
        False,
        said.STATUS_FAULT,
    )
    assert state.invalid == 1


def test_the_orientation_of_the_messages_says_what_is_vertical_where_that_is_asked_for() -> None:
    matrix = turn(0.2, -0.3, 0.5)
    message = imu(T0, *(matrix.T @ np.array([0.0, 0.0, GRAVITY + 1.0])))
    q = message.orientation
    q.x, q.y, q.z, q.w = quaternion(matrix)
    core = AdapterCore(replace(P, use_orientation=True), IMU)
    _, (said,) = fed(core, (0, message), (1, message))
    assert (said.sprung, said.unsprung) == pytest.approx((1.0, 1.0))
    message.orientation_covariance[0] = -1.0
    _, (said,) = fed(core, (0, message), (1, message))
    assert not said.valid


def test_accelerations_without_gravity_are_taken_as_they_are() -> None:
    message = AccelStamped()
    message.header.stamp, message.accel.linear.z = to_stamp(T0), -3.0
    _, (said,) = fed(
        AdapterCore(AdapterParameters(max_age=0.0), ACCEL), (1, message), (0, message)
    )
    assert (said.sprung, said.unsprung) == (-3.0, -3.0)


@pytest.mark.parametrize(
    ("program", "package"),
    [("autoware_adapter", "autoware_vehicle_msgs"), ("dynamic_joint_adapter", "control_msgs")],
)
def test_a_program_names_the_message_package_that_it_lacks(program: str, package: str) -> None:
    if find_spec(package):
        pytest.skip(f"{package} is there")
    code = f"from er_bringup.executables import {program} as main; main()"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 2
    assert done.stderr.splitlines() == [
        f"{program}: needs the Python module {package}: install rosdep's key {package} "
        "(rosdep install --from-paths src --ignore-src)"
    ]
