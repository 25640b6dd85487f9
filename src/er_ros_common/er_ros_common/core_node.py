"""The shell of a node that is a core: gives messages and the time to it, and publishes what it says."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from time import perf_counter
from typing import Any, ClassVar

from er_common.common_parameters import deaf_after
from er_models.constants import SAMPLE_TIME
from rclpy.qos import QoSProfile

from er_ros_common.core import Core, Said
from er_ros_common.graph_check import connected
from er_ros_common.managed import ManagedNode
from er_ros_common.topics import Topic


class CoreNode(ManagedNode):
    """A node around a core; subclasses fill `make` and `report`.

    watch_period: how often the silence of the inputs is looked at [s]; watch_patience: how long the core has nothing to
    say of it, where that is less than until they count as dead [s]; profile: of the subscriptions, None for that of
    each topic; whole: inputs of no use without all of their parts.
    p holds ``listeners``: how many of each output there must be before the node is ready.
    """

    watch_period: ClassVar[float] = 0.01
    watch_patience: ClassVar[float] = math.inf
    profile: ClassVar[QoSProfile | None] = None
    whole: ClassVar[tuple[Topic, ...]] = ()
    core: Any

    def make(self) -> Core:
        """The core of these parameters; raises `ErError` where that cannot be."""
        raise NotImplementedError

    def configure(self) -> None:
        """Make the core and the ends of its topics."""
        self.core = self.make()
        self.health.model_id, self.health.gains_id = self.core.model_id, self.core.gains_id
        self.ends = {topic.name: self.advertise(topic) for topic in self.core.outputs}
        rate = getattr(self.core.p, "rate", 0.0)  # not every core is made for one
        self.health.meter.deadline = 1.0 / rate if rate else SAMPLE_TIME
        self.inputs = {
            topic.name: self.subscribe(
                topic,
                partial(self.on_message, topic),
                self.profile,
                needed=topic not in self.core.optional,
                whole=topic in self.whole,
                limits=limits,
                rate=rate,
            )
            for topic, limits in zip(self.core.inputs, self.core.limits, strict=True)
        }
        patience = min(self.watch_patience, deaf_after(self.core.p))
        self.watch_every(self.watch_period, self.on_watch, patience)

    def begin(self) -> None:
        """Know nothing yet."""
        self.state = self.core.start()

    def on_message(self, topic: Topic, message: Any) -> None:
        """Take a message of an input."""
        began = perf_counter()
        if self.take(*self.core.on_message(self.state, topic, message, self.came)):
            self.health.meter.step(perf_counter() - began)

    def on_watch(self) -> None:
        """Go on where the inputs are silent."""
        self.take(*self.core.on_time(self.state, self.when()))

    def take(self, state: Any, said: list[Said]) -> bool:
        """Go over to a state, and publish what was said on the way; whether anything was."""
        self.state = state
        if said:
            self.publish(said)
        return bool(said)

    def publish(self, said: Sequence[Said]) -> None:
        """Publish messages of the core."""
        for topic, message in said:
            self.ends[topic.name].publish(message)

    def before_samples(self) -> tuple[str, str]:
        """Mode and reason of a node that has not heard anything yet."""
        optional = {topic.name for topic in self.core.optional}
        inputs = [each for name, each in self.inputs.items() if name not in optional]
        outputs = [(each, self.p.listeners) for each in self.ends.values()]
        if connected(inputs, outputs):
            return "ready", "no sample yet"
        return "waiting", "not connected yet"
