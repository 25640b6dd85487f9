"""The service ``~/inject_fault`` of a node, and the way of its messages through what was injected."""

from __future__ import annotations

import math
from collections.abc import Sequence
from random import Random
from threading import Lock
from time import monotonic
from typing import Any

from er_common.topics import Topic
from er_models.errors import InputError
from rclpy.publisher import Publisher

from er_damper_msgs.srv import InjectFault
from er_ros_common import log
from er_ros_common.injection import Channel, asked, described, taken_over, through
from er_ros_common.managed import ManagedNode

SERVICE = "~/inject_fault"


class FaultPort:
    """Everything that may be spoilt goes through `publish` or `taken`.

    units: topics that the node publishes or takes; enabled: else every request is refused; seed: of garbage and
    of what is missing; rate: messages of a topic per second of the steady clock [Hz].
    """

    def __init__(
        self,
        node: ManagedNode,
        units: Sequence[Topic],
        *,
        enabled: bool,
        seed: int,
        rate: float = math.inf,
    ) -> None:
        self.rate = rate
        self.node, self.enabled, self.random = node, enabled, Random(seed)
        self.fields = {topic.name: _numbers(topic) for topic in units}
        self.channels = {topic.name: Channel() for topic in units}
        self.touched = False
        # a bridge publishes from a thread of its own
        self.lock = Lock()
        node.offer(InjectFault, SERVICE, self.on_request)

    def publish(self, publisher: Publisher, topic: Topic, message: Any) -> None:
        """Publish what is left of a message."""
        if not self.touched:
            publisher.publish(message)
            return
        for each in self.taken(topic, message):
            publisher.publish(each)

    def taken(self, topic: Topic, message: Any) -> list[Any]:
        """What is left of a message; with delays also of earlier ones."""
        if not self.touched:
            return [message]
        with self.lock:
            channel, out = through(self.channels[topic.name], message, monotonic(), self.random)
            self.channels[topic.name] = channel
        return out

    @property
    def in_force(self) -> str:
        """What is injected at the moment, in words; empty where nothing is."""
        return described(self.channels, monotonic()) if self.touched else ""

    def on_request(
        self, request: InjectFault.Request, answer: InjectFault.Response
    ) -> InjectFault.Response:
        """Do it, or say why not."""
        if not self.enabled:
            answer.reason = "the parameter enable_fault_injection is false"
            return answer
        now = monotonic()
        given = (request.unit, int(request.kind), float(request.value), float(request.duration))
        try:
            unit, fault = asked(*given, self.fields, now, rate=self.rate)
        except InputError as error:
            answer.reason = str(error)
            return answer
        with self.lock:
            self.channels[unit] = taken_over(self.channels[unit], fault, now)
        self.touched = True
        answer.accepted, answer.reason = True, self.in_force or "nothing is injected"
        log.warning(self.node, f"injected: {answer.reason}")
        return answer


def _numbers(topic: Topic) -> tuple[str, ...]:
    kinds = topic.type.get_fields_and_field_types()
    return tuple(name for name, kind in kinds.items() if kind == "double")
