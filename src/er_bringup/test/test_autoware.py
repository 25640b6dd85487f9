"""Autoware's velocity report as the load on the body; its message package is not needed for that."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy")

from er_bringup.ros_autoware import REPORT, AutowareCore, AutowareParameters, State
from er_ros_common.clock import to_stamp
from er_ros_common.core import When
from geometry_msgs.msg import AccelStamped
from std_msgs.msg import Header

T0, PERIOD = 10**15, 20_000_000


def report(stamp: int, v_x: float, v_y: float = 0.0, turning: float = 0.0) -> Any:
    """What Autoware says of a vehicle, by the names of its fields."""
    try:
        made = REPORT.type()
    except ModuleNotFoundError:
        made = SimpleNamespace(header=Header())
    made.header.stamp, made.header.frame_id = to_stamp(stamp), "base_link"
    made.longitudinal_velocity, made.lateral_velocity, made.heading_rate = v_x, v_y, turning
    return made


def driven(reports: list[Any], **changes: float) -> tuple[State, list[AccelStamped]]:
    """State and messages after these reports."""
    core = AutowareCore(AutowareParameters(max_age=0.0, **changes))
    state, out = core.start(), []
    for k, message in enumerate(reports):
        state, said = core.on_message(state, REPORT, message, When(k * PERIOD, None))
        assert [topic.name for topic, _ in said] in ([], ["body/load"])
        out += [each for _, each in said]
    return state, out


def test_braking_is_felt_backwards_after_the_smoothing() -> None:
    _, out = driven([report(T0 + k * PERIOD, 20.0 - 3.0 * 0.02 * k) for k in range(60)])
    felt = [each.accel.linear.x for each in out]
    assert len(felt) == 59
    assert felt == sorted(felt, reverse=True)
    assert felt[4] == pytest.approx(
        -3.0 * (1.0 - math.exp(-1.0))
    )  # five periods: the time constant
    assert felt[-1] == pytest.approx(-3.0, rel=1e-4)
    assert (out[0].header.frame_id, out[0].header.stamp) == ("base_link", to_stamp(T0 + PERIOD))


def test_a_circle_is_felt_to_its_middle_in_whatever_axes() -> None:
    """Of a point that goes round at 8 m/s and 0.5 rad/s: 4 m/s2 to the left, and the same with side slip."""
    for slip in (0.0, -0.1):
        v = 8.0 * np.array([math.cos(slip), math.sin(slip)])
        _, out = driven([report(T0 + k * PERIOD, *v.tolist(), 0.5) for k in range(3)])
        found = [out[-1].accel.linear.x, out[-1].accel.linear.y]
        assert found == pytest.approx([-4.0 * math.sin(slip), 4.0 * math.cos(slip)])


def test_a_gap_begins_anew_and_nonsense_is_left_out() -> None:
    speed = [report(T0 + k * PERIOD, 10.0) for k in range(3)]
    later = [report(T0 + 10**9 + k * PERIOD, 30.0) for k in range(2)]
    state, out = driven([*speed, report(T0 + 3 * PERIOD, math.nan), speed[1], *later])
    assert len(out) == 3
    assert all(each.accel.linear.x == 0.0 for each in out)  # 20 m/s in a gap are no acceleration
    assert (state.invalid, state.last.stamp) == (1, T0 + 10**9 + PERIOD)
    core = AutowareCore(AutowareParameters())
    assert core.silent(state, state.heard + 300_000_000)
    assert not core.silent(state, state.heard + 100_000_000)
