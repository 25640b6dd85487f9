"""What `ros2 bag record` needs to lose nothing: quality of service of each topic, and the writer's options."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import yaml
from er_common.quality import RECORDER
from er_common.topics import Topic

from er_bringup.integration.panels import full
from er_bringup.programs import ESTIMATES
from er_common import topics

RECORDED = (*topics.MEASUREMENTS, *ESTIMATES)
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
    offered = topic.publisher
    return {
        "history": "keep_last",
        "depth": RECORDER.depth,
        "reliability": "reliable" if offered.reliable else "best_effort",
        "durability": "transient_local" if offered.latched else "volatile",
    }
