"""What `ros2 bag record` needs to lose nothing: quality of service of each topic, and the writer's options."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import yaml
from er_ros_common.topics import Topic
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from er_bringup.integration.panels import full
from er_ros_common import qos, topics

RECORDED = (*topics.MEASUREMENTS, *topics.ESTIMATES)
WRITER = {
    "compression": "Zstd",
    "compressionLevel": "Fast",
    "chunkSize": 786432,
    "noChunkCRC": False,
}
"""Options of the MCAP writer: a damaged chunk is noticed, and costs a second at most."""


def overrides(namespaces: Sequence[str]) -> str:
    """For --qos-profile-overrides-path: every contract topic of these namespaces."""
    found = {
        full(namespace, topic): _asked(topic) for namespace in namespaces for topic in RECORDED
    }
    found[topics.DIAGNOSTICS.name] = _asked(topics.DIAGNOSTICS)
    return yaml.safe_dump(found, sort_keys=False, width=99)


def writer() -> str:
    """For --storage-config-file."""
    return yaml.safe_dump(WRITER, sort_keys=False)


def _asked(topic: Topic) -> dict[str, Any]:
    """As reliable and latched as its publisher offers, with room for a stalled disk."""
    offered: QoSProfile = topic.publisher
    reliable = offered.reliability == ReliabilityPolicy.RELIABLE
    latched = offered.durability == DurabilityPolicy.TRANSIENT_LOCAL
    return {
        "history": "keep_last",
        "depth": qos.RECORDER.depth,
        "reliability": "reliable" if reliable else "best_effort",
        "durability": "transient_local" if latched else "volatile",
    }
