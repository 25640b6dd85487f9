"""The node of both adapters; what it does with messages is `er_bringup.ros_adapter`."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from time import perf_counter
from typing import Any

from er_common.program import Program
from er_common.topics import Topic
from er_ros_common.health import Report
from er_ros_common.help import Card
from er_ros_common.managed import ManagedNode
from er_ros_common.parameters import declare
from er_ros_common.spin import Executable

from er_bringup.ros_adapter import AdapterCore, AdapterParameters
from er_common import topics
from er_damper_msgs.msg import NodeStatus


class AdapterNode(ManagedNode):
    """Gives messages to the core and publishes what it says."""

    def __init__(
        self,
        program: Program,
        table: type[AdapterParameters],
        sensors: tuple[Topic, ...],
        argv: Sequence[str] | None = None,
    ) -> None:
        super().__init__(program.name, argv)
        self.sensors = sensors
        self.p = declare(self, table, self.changed)

    def configure(self) -> None:
        """Make the ends; the sensors' messages have no numbers to watch, but types and ends like any."""
        self.core = AdapterCore(self.p, self.sensors)
        self.out = self.advertise(topics.ACCELERATION)
        for topic in self.sensors:
            self.watched[topic.name] = topic
            heard = self.while_active(partial(self.on_sensor, topic))
            self.listen(topic.name, topic.type, heard, topic.subscriber)

    def tune(self, p: Any) -> None:
        """Go on with other values; what waits stays."""
        self.core = AdapterCore(p, self.sensors)

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
            mode, status, reason = (
                "waiting",
                NodeStatus.STATUS_INITIALIZING,
                "no pair of samples yet",
            )
        elif self.core.silent(state, self.when().steady):
            mode, status = "silent", NodeStatus.STATUS_LOST
            reason = f"no pair of samples for {self.p.timeout:g} s"
        values = {"samples without their other half": state.alone}
        return Report(
            mode, status, reason, state.stamps,
            invalid=state.invalid, valid=mode == "running", values=values,
        )  # fmt: skip


def executable(
    program: Program, table: type[AdapterParameters], sensors: tuple[Topic, ...]
) -> Executable:
    """The program of one kind of sensor."""
    says = (topics.ACCELERATION, topics.STATUS, topics.DIAGNOSTICS)
    card = Card(program, table, subscribes=sensors, publishes=says)
    return Executable(partial(AdapterNode, program, table, sensors), card)
