"""Names of topics, in full."""

from __future__ import annotations

from er_models.errors import ErError
from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node

from er_ros_common.private import RCLError

ALLOWED = "letters, digits and _, with / between, each beginning with no digit"


def resolved(node: Node, name: str, parameter: str = "") -> str:
    """Name of a topic after remapping, in the node's namespace; parameter: which one gave it.

    Raises:
        ErError: There can be no topic of that name.
    """
    try:
        return str(node.resolve_topic_name(name))
    except (InvalidTopicNameException, ValueError, RCLError):
        where = f"{parameter}: " if parameter else ""
        raise ErError(f"{where}topic '{name}': expected {ALLOWED}") from None
