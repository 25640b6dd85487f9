"""Plain numbers of a quality of service as ROS's profile."""

from __future__ import annotations

import pytest

pytest.importorskip("rclpy")

from er_common.quality import Quality
from er_ros_common.qos import profile
from rclpy.qos import DurabilityPolicy, HistoryPolicy, ReliabilityPolicy


@pytest.mark.parametrize("reliable", [False, True])
@pytest.mark.parametrize("latched", [False, True])
def test_a_profile_says_what_its_quality_says(*, reliable: bool, latched: bool) -> None:
    found = profile(Quality(7, reliable, latched))
    assert (found.history, found.depth) == (HistoryPolicy.KEEP_LAST, 7)
    assert (found.reliability == ReliabilityPolicy.RELIABLE) is reliable
    assert (found.reliability == ReliabilityPolicy.BEST_EFFORT) is not reliable
    assert (found.durability == DurabilityPolicy.TRANSIENT_LOCAL) is latched
    assert (found.durability == DurabilityPolicy.VOLATILE) is not latched
