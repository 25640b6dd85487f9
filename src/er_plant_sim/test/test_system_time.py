"""Stamps follow a system clock that was set, before anybody refuses them."""

from __future__ import annotations

from time import monotonic_ns, time_ns

import pytest
from er_common.stamps import StampLimits, Verdict, judge
from er_plant_sim.nodes.system_time import SystemTime

MS = 1_000_000
OFFSET = 1_700_000_000_000_000_000
DEVICE = MS
"""Deviation of the device's clock up to which samples are given on [ns]."""


@pytest.mark.parametrize("step", [-1000, -7, -5, -4, -3, -1, 0, 1, 7, 19, 1000])
def test_no_step_of_the_system_clock_makes_stamps_that_are_refused(step: int) -> None:
    offset = [OFFSET]
    times = SystemTime(lambda: offset[0])
    offset[0] += step * MS
    times.follow()
    for steady in (5 * MS, 10_000 * MS):
        now = steady + offset[0]
        verdict = judge(StampLimits(), 0, times.stamp(steady + DEVICE), now)
        assert verdict is Verdict.FIRST
    assert times.steps == (abs(step) >= 3)
    times.follow()
    assert times.steps == (abs(step) >= 3)


def test_small_corrections_move_no_stamp() -> None:
    offset = [OFFSET]
    times = SystemTime(lambda: offset[0])
    offset[0] += MS
    times.follow()
    assert times.stamp(0) == OFFSET


def test_the_system_clock_is_read_as_it_is() -> None:
    before = time_ns()
    stamp = SystemTime().stamp(monotonic_ns())
    assert before - MS < stamp < time_ns() + MS
