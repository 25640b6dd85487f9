"""The shell that all observer nodes share; what it does with messages is `er_observers.ros_core`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import partial
from time import monotonic_ns, perf_counter
from typing import Any

from er_ros_common.clock import now
from er_ros_common.core import Said, When
from er_ros_common.graph_check import connected
from er_ros_common.health import Report
from er_ros_common.help import Card
from er_ros_common.managed import ManagedNode
from er_ros_common.parameters import declare
from er_ros_common.spin import Executable
from std_msgs.msg import String

from er_damper_msgs.msg import NodeStatus
from er_observers.ros_core import ON_THE_WIRE, ObserverCore
from er_observers.settings import ObserverParameters
from er_ros_common import qos, topics

GAIN_INFO = topics.Topic(
    "~/gain_info",
    String,
    "what the gains are and promise, JSON",
    0.0,
    *(topics.STATUS.publisher,) * 2,
)
WATCH_PERIOD = 0.01
"""How often the silence of the inputs is looked at [s]."""


class ObserverNode(ManagedNode):
    """Gives messages to the core and publishes what it says.

    observer: name its gains are kept under.
    """

    def __init__(self, name: str, argv: Sequence[str] | None = None) -> None:
        super().__init__(f"{name}_observer", argv)
        self.name = name
        self.p = declare(self, ObserverParameters)

    def configure(self) -> None:
        """Load model and gains, which must belong together, and make the ends."""
        self.core = ObserverCore(self.name, self.p)
        self.health.model_id, self.health.gains_id = self.core.model_id, self.core.gains_id
        self.force = self.advertise(self.core.topic)
        self.advertise(GAIN_INFO).publish(String(data=self._gain_info()))
        self.inputs = [
            self.subscribe(topic, partial(self.on_message, topic), qos.FOLLOWER)
            for topic in ObserverCore.inputs
        ]
        self.every(WATCH_PERIOD, self.on_watch)

    def begin(self) -> None:
        """Know nothing yet."""
        self.state = self.core.start()

    def _gain_info(self) -> str:
        g = self.core.gains
        return json.dumps(
            {"observer": g.observer, "gains": g.digest, "model": g.model, **g.figures}, default=str
        )

    def on_message(self, topic: topics.Topic, message: Any) -> None:
        """Take a message of an input."""
        began = perf_counter()
        self.state, said = self.core.on_message(self.state, topic, message, self.when())
        self.publish(said)
        if said:
            self.health.meter.step(perf_counter() - began)

    def on_watch(self) -> None:
        """Look whether the samples stay away."""
        self.state, said = self.core.on_time(self.state, self.when())
        self.publish(said)

    def when(self) -> When:
        """Now, on both clocks."""
        return When(monotonic_ns(), now(self))

    def publish(self, said: list[Said]) -> None:
        """Publish estimates."""
        for _, message in said:
            self.force.publish(message)

    def report(self) -> Report:
        """Health of the observer."""
        s = self.state
        ready = connected(self.inputs, [(self.force, self.p.listeners)])
        mode, reason = ("ready", "no sample yet") if ready else ("waiting", "not connected yet")
        status = NodeStatus.STATUS_INITIALIZING
        values: dict[str, object] = {"duties lost": s.feed.lost}
        if s.mind is not None:
            mode, estimate = "running", s.mind.estimate
            status, reason = ON_THE_WIRE[estimate.status], estimate.reason
            values |= {"test ratio": f"{estimate.test_ratio:.2f}", "resets": s.mind.resets}
        if s.silent:
            mode, status = "silent", NodeStatus.STATUS_LOST
            reason = f"no sample for {self.p.timeout:g} s"
        return Report(
            mode,
            status,
            reason,
            stamps=s.stamps,
            invalid=s.unusable,
            valid=mode == "running" and status != NodeStatus.STATUS_LOST,
            values=values,
        )


def card(name: str, topic: topics.Topic, text: str) -> Card:
    """What the node called `name`_observer is, for its `--help`."""
    return Card(
        package="er_observers",
        executable=f"{name}_observer",
        text=text,
        parameters=ObserverParameters,
        subscribes=ObserverCore.inputs,
        publishes=(topic, GAIN_INFO, topics.STATUS, topics.DIAGNOSTICS),
    )


def node_of(name: str, topic: topics.Topic, text: str) -> Executable:
    """The program of one observer."""
    return Executable(partial(ObserverNode, name), card(name, topic, text))
