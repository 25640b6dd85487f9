"""The node between ros2_control and a corner; what it does with messages is `er_bringup.ros_joint`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import partial
from time import perf_counter
from typing import Any

from er_ros_common.core import When
from er_ros_common.graph_check import connected
from er_ros_common.health import Report
from er_ros_common.help import Card
from er_ros_common.managed import ManagedNode
from er_ros_common.parameters import declare
from er_ros_common.spin import Executable, run

from er_bringup.ros_joint import COMMANDS, STATES, JointCore, JointParameters
from er_damper_msgs.msg import NodeStatus
from er_ros_common import topics

NOW = When(0, None)
"""The core judges no ages: the plant does."""


class JointNode(ManagedNode):
    """Gives messages to the core and publishes what it says."""

    def __init__(self, argv: Sequence[str] | None = None) -> None:
        super().__init__("ros2_control_joint", argv)
        self.p: JointParameters = declare(self, JointParameters)

    def configure(self) -> None:
        """Make the ends."""
        self.core = JointCore(self.p)
        self.out = {topic.name: self.advertise(topic) for topic in self.core.outputs}
        sensors = [topic for topic in self.core.inputs if topic is not COMMANDS]
        self.ends = [self.subscribe(topic, partial(self.on_message, topic)) for topic in sensors]
        # no message of ours: it has no sequence number to watch
        commanded = self.while_active(partial(self.on_message, COMMANDS))
        self.listen(COMMANDS.name, COMMANDS.type, commanded, COMMANDS.subscriber)

    def begin(self) -> None:
        """Know nothing yet."""
        self.state = self.core.start()

    def on_message(self, topic: topics.Topic, message: Any) -> None:
        """Take a message of an input."""
        began = perf_counter()
        self.state, said = self.core.on_message(self.state, topic, message, NOW)
        for to, answer in said:
            self.out[to.name].publish(answer)
        if said:
            self.health.meter.step(perf_counter() - began)

    def report(self) -> Report:
        """Health of the node."""
        if not self.state.last.seq:
            ready = connected(self.ends[:1])
            mode, reason = (
                ("ready", "no sample yet") if ready else ("waiting", "not connected yet")
            )
            return Report(mode, NodeStatus.STATUS_INITIALIZING, reason)
        return Report("running", invalid=self.state.refused)


CARD = Card(
    package="er_bringup",
    executable="ros2_control_joint",
    text="A corner as a joint of ros2_control: states and commands as sensor_msgs/JointState.",
    parameters=JointParameters,
    subscribes=(topics.DEFLECTION, topics.FORCE, COMMANDS),
    publishes=(STATES, topics.PWM_COMMAND, topics.STATUS, topics.DIAGNOSTICS),
)
NODE = Executable(JointNode, CARD)


def main() -> None:
    """Entry point of the executable."""
    sys.exit(run(JointNode, CARD))


if __name__ == "__main__":
    main()
