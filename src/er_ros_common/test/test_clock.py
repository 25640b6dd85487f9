"""Stamps to and from numbers; the timer is covered by test_spin."""

from __future__ import annotations

import pytest
from builtin_interfaces.msg import Time

from er_ros_common import clock


@pytest.mark.parametrize(
    "nanoseconds", [0, 1, 999_999_999, 1_000_000_000, 1_795_000_000_123_456_789]
)
def test_nanoseconds_survive_the_stamp(nanoseconds: int) -> None:
    assert clock.from_stamp(clock.to_stamp(nanoseconds)) == nanoseconds


@pytest.mark.parametrize(("sec", "nanosec"), [(-5, 0), (-1, 999_999_999), (1, 1_000_000_000)])
def test_a_stamp_that_is_no_time_is_one_that_is_not_set(sec: int, nanosec: int) -> None:
    assert clock.from_stamp(Time(sec=sec, nanosec=nanosec)) == 0


@pytest.mark.parametrize("nanoseconds", [-1, 2**31 * 1_000_000_000])
def test_times_a_stamp_cannot_hold_are_refused(nanoseconds: int) -> None:
    with pytest.raises(ValueError, match="a stamp holds"):
        clock.to_stamp(nanoseconds)
