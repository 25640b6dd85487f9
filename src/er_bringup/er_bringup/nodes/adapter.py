"""The node of the adapters; what each does with messages is its core.

The cores: `ros_adapter`, `ros_joint_states` and `ros_autoware`.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from functools import partial
from time import perf_counter
from typing import Any, Protocol

from er_common.program import Program
from er_common.topics import Topic
from er_ros_common.core import Said, When
from er_ros_common.health import Report
from er_ros_common.help import Card
from er_ros_common.managed import ManagedNode
from er_ros_common.parameters import declare
from er_ros_common.spin import Executable, run

from er_common import topics
from er_damper_msgs.msg import NodeStatus


class AdapterCore(Protocol):
    """What messages of a vehicle are made into, without a node.

    awaited: what it publishes something of, in words; its state holds the tick of the last one (`last`), when
    that was heard (`heard`), checks of stamps (`stamps`) and how many were of no use (`invalid`).
    """

    inputs: tuple[Topic, ...]
    output: Topic
    awaited: str

    def start(self) -> Any:
        """Before any message."""

    def silent(self, state: Any, steady: int) -> bool:
        """Whether samples stay away, at a time on the steady clock [ns]."""

    def on_message(
        self, state: Any, topic: Topic, message: Any, when: When, /
    ) -> tuple[Any, list[Said]]:
        """Take a message."""

    def values(self, state: Any) -> dict[str, object]:
        """What else it tells of itself."""


class AdapterNode(ManagedNode):
    """Gives messages to the core and publishes what it says."""

    def __init__(
        self,
        program: Program,
        table: type[Any],
        make: Callable[[Any], AdapterCore],
        argv: Sequence[str] | None = None,
    ) -> None:
        super().__init__(program.name, argv)
        self.make = make
        self.p = declare(self, table, self.changed)

    def configure(self) -> None:
        """Make the ends; the sensors' messages have no numbers to watch, but types and ends like any."""
        self.core = self.make(self.p)
        self.out = self.advertise(self.core.output)
        for topic in self.core.inputs:
            self.watched[topic.name] = topic
            heard = self.while_active(partial(self.on_sensor, topic))
            self.listen(topic.name, topic.type, heard, topic.subscriber)

    def tune(self, p: Any) -> None:
        """Go on with other values; what waits stays."""
        self.core = self.make(p)

    def begin(self) -> None:
        """Know nothing yet."""
        self.state = self.core.start()

    def on_sensor(self, topic: Topic, message: Any) -> None:
        """Take a sample of one sensor."""
        began = perf_counter()
        self.state, said = self.core.on_message(self.state, topic, message, self.when())
        for _, answer in said:
            self.out.publish(answer)
        if said:
            self.health.meter.step(perf_counter() - began)

    def report(self) -> Report:
        """Health of the node."""
        state = self.state
        mode, status, reason = "running", NodeStatus.STATUS_OK, ""
        if not state.last.stamp:
            mode, status = "waiting", NodeStatus.STATUS_INITIALIZING
            reason = f"no {self.core.awaited} yet"
        elif self.core.silent(state, self.when().steady):
            mode, status = "silent", NodeStatus.STATUS_LOST
            reason = f"no {self.core.awaited} for {self.p.timeout:g} s"
        return Report(
            mode, status, reason, state.stamps,
            invalid=state.invalid, valid=mode == "running", values=self.core.values(state),
        )  # fmt: skip


def executable(
    program: Program,
    table: type[Any],
    make: Callable[[Any], AdapterCore],
    inputs: tuple[Topic, ...],
    output: Topic,
) -> Executable:
    """The program of one adapter; inputs, output: those of its core."""
    says = (output, topics.STATUS, topics.DIAGNOSTICS)
    card = Card(program, table, subscribes=inputs, publishes=says)
    return Executable(partial(AdapterNode, program, table, make), card)


def entry(node: Executable) -> Callable[[], None]:
    """The entry point of an adapter; it raises `ModuleNotFoundError` where a message package is not there."""

    def main() -> None:
        if not {"-h", "--help"} & {*sys.argv}:
            for topic in node.card.subscribes:
                _ = topic.type
        sys.exit(run(node.make, node.card))

    return main
