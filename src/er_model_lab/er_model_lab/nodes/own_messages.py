"""Which messages are the recorder's own: it sends some into every graph, also into an empty one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.serialization import deserialize_message

from er_model_lab.nodes.selection import message_class

SENDERS: dict[str, Callable[[Any], set[str]]] = {
    "diagnostic_msgs/msg/DiagnosticArray": lambda m: {
        f"/{each.name.rpartition(': ')[0].lstrip('/')}" for each in m.status
    },
    "rcl_interfaces/msg/Log": lambda m: {f"/{m.name.replace('.', '/')}"},
    "rcl_interfaces/msg/ParameterEvent": lambda m: {m.node},
}
"""Full names of the nodes that a message speaks of, by type: topics that all nodes share."""


def own(node: Node, name: str, type_name: str) -> Callable[[bytes], bool]:
    """What tells whether a serialized message on a topic comes from this node; decided once for the topic."""
    full = node.get_fully_qualified_name()
    if name.startswith(f"{full}/"):
        return lambda _: True
    senders = SENDERS.get(type_name)
    if senders is None:
        return lambda _: False
    kind = message_class(type_name)
    return lambda data: senders(deserialize_message(data, kind)) <= {full}
