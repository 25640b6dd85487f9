"""Time: timers on the steady clock, and stamps to and from nanoseconds."""

from __future__ import annotations

from collections.abc import Callable
from time import time_ns
from typing import Final

from builtin_interfaces.msg import Time
from er_common.stamps import SECOND
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.timer import Timer

#: seconds of a stamp are a signed 32-bit integer
LAST_SECOND: Final = 2**31 - 1
LAST_STAMP: Final = LAST_SECOND * SECOND
"""From here on a time [ns] is no stamp."""


def wall_timer(node: Node, period: float, callback: Callable[[], None]) -> Timer:
    """Timer [s] on the steady clock, also in simulated time: for watching and reporting."""
    clock = Clock(clock_type=ClockType.STEADY_TIME)
    return node.create_timer(period, callback, clock=clock)


def until_next(timer: Timer) -> int:
    """Time until a timer is due again [ns]."""
    return int(timer.time_until_next_call())


def now(node: Node) -> int:
    """Time of the node's clock [ns]: the system's, or /clock when use_sim_time is true."""
    clock = node.get_clock()
    # the system's is asked without rclpy, at a fifth of the cost
    return int(clock.now().nanoseconds) if clock.ros_time_is_active else time_ns()


def to_stamp(nanoseconds: int) -> Time:
    """Stamp of a time [ns] since the clock's start.

    Raises:
        ValueError: before the start or beyond what a stamp can hold.
    """
    sec, nanosec = split(nanoseconds)
    return Time(sec=sec, nanosec=nanosec)


def split(nanoseconds: int) -> tuple[int, int]:
    """Seconds and nanoseconds of a stamp for a time [ns] since the clock's start.

    Raises:
        ValueError: before the start or beyond what a stamp can hold.
    """
    second, rest = divmod(int(nanoseconds), SECOND)
    if not 0 <= second <= LAST_SECOND:
        raise ValueError(f"a stamp holds 0 to {LAST_SECOND} s, not {second} s")
    return second, rest


def from_stamp(stamp: Time) -> int:
    """Time of a stamp [ns]; 0 as in `joined`."""
    return joined(stamp.sec, stamp.nanosec)


def joined(sec: int, nanosec: int) -> int:
    """Time of a stamp's parts [ns]; 0, as where it is not set, where seconds are negative or nanoseconds a second."""
    return sec * SECOND + nanosec if sec >= 0 and nanosec < SECOND else 0
