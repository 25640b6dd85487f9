"""The Skyhook controller node: answers every sample with a duty; see `er_ftc_controller.ros_skyhook`.

Where samples stay away it asks for the safe duty, and once more when it is stopped: the last
command is never the last thing that was right some time ago.
"""

from __future__ import annotations

import sys
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
from er_ros_common.spin import Executable, run

from er_damper_msgs.msg import NodeStatus
from er_ftc_controller.ros_skyhook import SkyhookCore, SkyhookParameters
from er_ros_common import topics

WATCH_PERIOD = 0.01
"""How often the silence of the inputs is looked at [s]."""


class SkyhookController(ManagedNode):
    """Gives messages to the core and publishes what it says."""

    def __init__(self, argv: Sequence[str] | None = None) -> None:
        super().__init__("skyhook_controller", argv)
        self.p = declare(self, SkyhookParameters)

    def configure(self) -> None:
        """Make the law and the ends."""
        self.core = SkyhookCore(self.p)
        self.command = self.advertise(topics.PWM_COMMAND)
        self.inputs = [
            self.subscribe(topic, partial(self.on_message, topic)) for topic in SkyhookCore.inputs
        ]
        self.every(WATCH_PERIOD, self.on_watch)

    def begin(self) -> None:
        """Know nothing yet."""
        self.state = self.core.start()

    def on_message(self, topic: topics.Topic, message: Any) -> None:
        """Take half of a sample."""
        began = perf_counter()
        self.state, said = self.core.on_message(self.state, topic, message, self.when())
        self.publish(said)
        if said:
            self.health.meter.step(perf_counter() - began)

    def on_watch(self) -> None:
        """Look whether the inputs are silent."""
        self.state, said = self.core.on_time(self.state, self.when())
        self.publish(said)

    def when(self) -> When:
        """Now, on both clocks."""
        return When(monotonic_ns(), now(self))

    def publish(self, said: list[Said]) -> None:
        """Publish commands."""
        for _, message in said:
            self.command.publish(message)

    def report(self) -> Report:
        """Health of the controller."""
        s, mode, status, reason = self.state, "running", NodeStatus.STATUS_OK, ""
        if not s.heard:
            ready = connected(self.inputs, [(self.command, self.p.listeners)])
            mode, reason = (
                ("ready", "no sample yet") if ready else ("waiting", "not connected yet")
            )
            status = NodeStatus.STATUS_INITIALIZING
        elif s.safe:
            mode, status = "safe", NodeStatus.STATUS_LOST
            reason = f"no usable sample for {self.p.timeout:g} s: safe duty"
        values = {
            "sprung velocity [m/s]": f"{s.mind.velocity:.4f}",
            "halves without partner": s.pairs.unmatched,
        }
        return Report(
            mode,
            status,
            reason,
            stamps=s.stamps,
            invalid=s.unusable,
            valid=mode == "running",
            values=values,
        )

    def end(self) -> None:
        """Leave the safe duty behind."""
        self.publish(self.core.last_words(self.state, now(self)))


CARD = Card(
    package="er_ftc_controller",
    executable="skyhook_controller",
    text="Two-state Skyhook (3.81): full field where the damper brakes the body.",
    parameters=SkyhookParameters,
    subscribes=SkyhookCore.inputs,
    publishes=(topics.PWM_COMMAND, topics.STATUS, topics.DIAGNOSTICS),
)


NODE = Executable(SkyhookController, CARD)


def main() -> None:
    """Entry point of the executable."""
    sys.exit(run(SkyhookController, CARD))


if __name__ == "__main__":
    main()
