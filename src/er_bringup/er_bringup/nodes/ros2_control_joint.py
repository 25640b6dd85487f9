"""The node between ros2_control and a corner; what it does with messages is `er_bringup.ros_joint`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import partial
from time import perf_counter
from typing import Any

from er_ros_common.graph_check import connected
from er_ros_common.health import Report
from er_ros_common.help import Card
from er_ros_common.managed import ManagedNode
from er_ros_common.parameters import declare
from er_ros_common.spin import Executable, run

from er_bringup.programs import JOINT
from er_bringup.ros_joint import (
    COMMANDS,
    DUTY_COMMANDS,
    DUTY_STATES,
    STATES,
    JointCore,
    JointParameters,
)
from er_common import topics
from er_damper_msgs.msg import NodeStatus


class JointNode(ManagedNode):
    """Gives messages to the core and publishes what it says."""

    def __init__(self, argv: Sequence[str] | None = None) -> None:
        super().__init__(JOINT.name, argv)
        self.p: JointParameters = declare(self, JointParameters, self.changed)

    def configure(self) -> None:
        """Make the ends."""
        self.core = JointCore(self.p)
        self.out = {topic.name: self.advertise(topic) for topic in self.core.outputs}
        self.ends = [
            self.subscribe(
                topic, partial(self.take, topic), needed=topic is not topics.PWM_APPLIED
            )
            for topic in self.core.inputs
        ]
        for topic in self.core.commands:
            # no message of ours: it has no sequence number to watch, but types and ends like any
            self.watched[topic.name] = topic
            commanded = self.while_active(partial(self.take, topic))
            self.listen(topic.name, topic.type, commanded, topic.subscriber)

    def tune(self, p: JointParameters) -> None:
        """Go on with another patience."""
        self.core = self.core.tuned(p)

    def begin(self) -> None:
        """Know nothing yet."""
        self.state = self.core.start()

    def take(self, topic: topics.Topic, message: Any) -> None:
        """Give a message to the core and publish what it says."""
        began = perf_counter()
        when = self.when() if topic in self.core.commands else self.came
        self.state, said = self.core.on_message(self.state, topic, message, when)
        for to, answer in said:
            self.out[to.name].publish(answer)
        if said:
            self.health.meter.step(perf_counter() - began)

    def report(self) -> Report:
        """Health of the node."""
        state = self.state
        mode, status, reason = "running", NodeStatus.STATUS_OK, ""
        if not state.last.stamp:
            ready = connected(self.ends[:1])
            mode, reason = (
                ("ready", "no sample yet") if ready else ("waiting", "not connected yet")
            )
            status = NodeStatus.STATUS_INITIALIZING
        elif self.core.silent(state, self.when().steady):
            mode, status = "silent", NodeStatus.STATUS_LOST
            reason = (
                f"no usable sample for {self.p.timeout:g} s: no joint states, commands refused"
            )
        elif state.lacks:
            status = NodeStatus.STATUS_DEGRADED
            reason = f"joint states without what is not usable: {', '.join(state.lacks)}"
        values = {"commands refused": state.refused, "samples unusable": state.unusable}
        return Report(
            mode, status, reason, state.stamps,
            invalid=state.unusable, valid=mode == "running", values=values,
        )  # fmt: skip


CARD = Card(
    JOINT,
    JointParameters,
    subscribes=(topics.DEFLECTION, topics.FORCE, topics.PWM_APPLIED, COMMANDS, DUTY_COMMANDS),
    publishes=(STATES, DUTY_STATES, topics.PWM_COMMAND, topics.STATUS, topics.DIAGNOSTICS),
)
NODE = Executable(JointNode, CARD)


def main() -> None:
    """Entry point of the executable."""
    sys.exit(run(JointNode, CARD))


if __name__ == "__main__":
    main()
