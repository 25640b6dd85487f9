"""ROS's profiles of the quality of service that `er_common.quality` writes down."""

from __future__ import annotations

from functools import cache

from er_common.quality import Quality
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy


@cache
def profile(asked: Quality) -> QoSProfile:
    """The profile; one for each quality."""
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=asked.depth,
        reliability=ReliabilityPolicy.RELIABLE
        if asked.reliable
        else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL
        if asked.latched
        else DurabilityPolicy.VOLATILE,
    )
