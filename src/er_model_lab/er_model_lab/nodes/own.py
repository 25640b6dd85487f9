"""Which messages are the recorder's own: it sends some into every graph, also into an empty one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.serialization import deserialize_message

from er_model_lab.nodes.selection import message_class

SENDERS: dict[str, Callable[[Any], set[str]]] = {
    "diagnostic_msgs/msg/DiagnosticArray": lambda m: {
        each.name.rpartition(": ")[0] for each in m.status
    },
    "rcl_interfaces/msg/Log": lambda m: {f"/{m.name.replace('.', '/')}"},
    "rcl_interfaces/msg/ParameterEvent": lambda m: {m.node},
}
"""Full names of the nodes that a message speaks of, by type: topics that all nodes share."""


def is_own(node: Node, name: str, type_name: str, data: bytes) -> bool:
    """Whether a serialized message on a topic comes from this node."""
    full = node.get_fully_qualified_name()
    if name.startswith(f"{full}/"):
        return True
    senders = SENDERS.get(type_name)
    if senders is None:
        return False
    return senders(deserialize_message(data, message_class(type_name))) <= {full}
