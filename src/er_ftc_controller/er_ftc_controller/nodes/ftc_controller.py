"""The fault-tolerant controller node: answers every sample with a duty; see `er_ftc_controller.control`."""

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
from er_ftc_controller.control import Mode
from er_ftc_controller.ros_core import FtcCore
from er_ftc_controller.settings import FtcParameters
from er_ros_common import topics

WATCH_PERIOD = 0.005
"""How often the silence of the inputs is looked at [s]."""


class FtcController(ManagedNode):
    """Gives messages to the core and publishes what it says."""

    def __init__(self, argv: Sequence[str] | None = None) -> None:
        super().__init__("ftc_controller", argv)
        self.p = declare(self, FtcParameters)

    def configure(self) -> None:
        """Load the gains and make the ends."""
        self.core = FtcCore(self.p)
        self.health.model_id, self.health.gains_id = self.core.model_id, self.core.gains_id
        self.command = self.advertise(topics.PWM_COMMAND)
        self.inputs = [
            # without a fault estimator the damper is taken for healthy
            self.subscribe(t, partial(self.on_message, t), needed=t is not topics.FAULT)
            for t in FtcCore.inputs
        ]
        self.every(WATCH_PERIOD, self.on_watch)

    def begin(self) -> None:
        """Know nothing yet."""
        self.state = self.core.start()

    def on_message(self, topic: topics.Topic, message: Any) -> None:
        """Take a message of an input."""
        began = perf_counter()
        before = self.state.command
        self.state, said = self.core.on_message(self.state, topic, message, self.when())
        self.publish(said, before)
        if said:
            self.health.meter.step(perf_counter() - began)

    def on_watch(self) -> None:
        """Go on where the inputs are silent."""
        before = self.state.command
        self.state, said = self.core.on_time(self.state, self.when())
        self.publish(said, before)

    def when(self) -> When:
        """Now, on both clocks."""
        return When(monotonic_ns(), now(self))

    def publish(self, said: list[Said], before: Any) -> None:
        """Publish commands, and a change of mode or reason at once."""
        for _, message in said:
            self.command.publish(message)
        after = self.state.command
        if (before.mode, before.reason) != (after.mode, after.reason):
            self.health.publish_status()

    def report(self) -> Report:
        """Health of the controller."""
        state, command = self.state, self.state.command
        mode, reason, status = command.mode.value, command.reason, NodeStatus.STATUS_OK
        if command.mode is Mode.SAFE:
            status = NodeStatus.STATUS_LOST
        if not state.heard:
            # a fault estimator may be missing: the damper is then taken for healthy
            ready = connected(self.inputs[:2], [(self.command, self.p.listeners)])
            status = NodeStatus.STATUS_INITIALIZING
            mode, reason = (
                ("ready", "no sample yet") if ready else ("waiting", "not connected yet")
            )
        values = {
            "rho": f"{command.rho:.3f}",
            "force asked for [N]": f"{command.wanted:.2f}",
            "factors in use f1 f2 f3": " ".join(f"{f:.3f}" for f in command.left),
            "fault estimates": state.told,
            "halves without partner": state.pairs.unmatched,
        }
        return Report(
            mode,
            status,
            reason,
            stamps=state.stamps,
            invalid=state.unusable,
            valid=bool(state.heard) and command.mode is not Mode.SAFE,
            values=values,
        )

    def end(self) -> None:
        """Leave the safe duty behind."""
        for _, message in self.core.last_words(self.state, now(self)):
            self.command.publish(message)


CARD = Card(
    package="er_ftc_controller",
    executable="ftc_controller",
    text="Fault-tolerant LPV control: domain (6.14), rho (6.16), LPV controller (6.27), inner force loop (2.10).",
    parameters=FtcParameters,
    subscribes=FtcCore.inputs,
    publishes=(topics.PWM_COMMAND, topics.STATUS, topics.DIAGNOSTICS),
)


NODE = Executable(FtcController, CARD)


def main() -> None:
    """Entry point of the executable."""
    sys.exit(run(FtcController, CARD))


if __name__ == "__main__":
    main()
