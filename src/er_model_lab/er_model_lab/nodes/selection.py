"""Which topics a recorder takes, and how it subscribes to them."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from er_ros_common.names import resolved
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.topic_endpoint_info import TopicEndpointInfo
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)

from er_common import topics

KNOWN = (*topics.MEASUREMENTS, topics.FAULT, topics.MODEL_FORCE, topics.MODEL_RESIDUAL)
"""Topics that are subscribed to before anybody publishes them; so are estimated forces that it was told of."""
ENDINGS = ("/status", "/gain_info", "/model_info")
"""Of the topics that nodes keep below their own name."""


class Selection:
    """The contract's topics in the namespace of a node, or given names, or everything.

    sources: topics that there will be.
    """

    def __init__(
        self,
        node: Node,
        names: tuple[str, ...],
        sources: tuple[str, ...] = (),
        *,
        everything: bool,
    ) -> None:
        self.node, self.everything = node, everything
        self.namespace = node.get_namespace().rstrip("/")
        told = (name.partition(topics.ESTIMATED) for name in sources)
        forces = (topics.estimated_force(name) for before, _, name in told if name and not before)
        known = (*KNOWN, *forces)
        self.types = {} if names else {self.full(t.name): t.type_name for t in known}
        self.names = {self.full(name) for name in names}

    def full(self, name: str) -> str:
        """Name of a topic after remapping, in the node's namespace.

        Raises:
            ErError: There can be no topic of that name.
        """
        return resolved(self.node, name)

    def wants(self, name: str) -> bool:
        """Whether a topic on the graph is to be recorded."""
        if self.everything:
            return True
        if self.names:
            return name in self.names
        inside = name.startswith(f"{self.namespace}/")
        own = name.removeprefix(f"{self.namespace}/")
        listed = (
            name in self.types
            or own.startswith(topics.ESTIMATED)
            or name == topics.DIAGNOSTICS.name
        )
        return listed or (inside and own.endswith(ENDINGS))

    def offered(self) -> dict[str, str]:
        """Wanted topics to their type: those known beforehand, and those on the graph now."""
        found = dict(self.types)
        for name, kinds in self.node.get_topic_names_and_types():
            if self.wants(name) and name not in found:
                found[name] = kinds[0]
        return found


def message_class(type_name: str) -> Any:
    """Python class of a type (`package/msg/Name`); None where its package is missing."""
    package, _, name = type_name.partition("/msg/")
    try:
        return getattr(import_module(f"{package}.msg"), name, None)
    except ImportError:
        return None


def offers(publishers: list[TopicEndpointInfo]) -> list[Qos]:
    """The publishers' quality of service in the form a bag stores."""
    return [_stored(info.qos_profile) for info in publishers]


def _stored(p: QoSProfile) -> Qos:
    # the graph does not report history and depth: unknown, as rosbag2 writes it
    forever = QosTime(9223372036, 854775807)
    return Qos(
        QosHistory.UNKNOWN,
        0,
        QosReliability(int(p.reliability)),
        QosDurability(int(p.durability)),
        forever,
        forever,
        QosLiveliness.AUTOMATIC,
        forever,
        avoid_ros_namespace_conventions=False,
    )
