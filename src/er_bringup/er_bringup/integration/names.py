"""The names of a corner in a vehicle stack, and which way they go."""

from __future__ import annotations

from er_common.topics import Topic

from er_bringup.graph import STACK_PUBLISHES
from er_bringup.programs import ESTIMATES
from er_common import topics

BASE = "/vehicle/suspension"
OUT = (topics.PWM_COMMAND, *ESTIMATES)
"""What a corner gives to the stack."""


def table(corner: str = "<corner>") -> str:
    """The table of names in Markdown."""
    lines = ["| topic of a node | name in the vehicle | type | way |", "|---|---|---|---|"]
    lines += [_row(topic, corner, "stack to corner") for topic in STACK_PUBLISHES]
    lines += [_row(topic, corner, "corner to stack") for topic in OUT]
    rig = (topics.FORCE, topics.ROAD)
    lines += [_row(topic, corner, "rig and simulation only") for topic in rig]
    return "\n".join(lines)


def _row(topic: Topic, corner: str, way: str) -> str:
    return f"| `{topic.name}` | `{BASE}/{corner}/{topic.name}` | `{topic.type_name}` | {way} |"
