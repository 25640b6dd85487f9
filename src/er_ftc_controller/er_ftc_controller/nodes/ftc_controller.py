"""The fault-tolerant controller node: answers every sample with a duty; see `er_ftc_controller.control`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

from er_common.stamps import SECOND
from er_ros_common.core import Said
from er_ros_common.core_node import CoreNode
from er_ros_common.health import Report
from er_ros_common.help import Card
from er_ros_common.parameters import declare
from er_ros_common.spin import Executable, run

from er_damper_msgs.msg import NodeStatus
from er_ftc_controller.control import Mode
from er_ftc_controller.ros_ftc import FtcCore
from er_ftc_controller.settings import FtcParameters
from er_ros_common import topics

REMEMBERED = SECOND
"""How long an acceleration that was not used is still said [ns]."""


class FtcController(CoreNode):
    """The core with its health; without a fault estimator the damper is taken for healthy."""

    watch_period, whole = 0.005, (topics.DEFLECTION,)

    def __init__(self, argv: Sequence[str] | None = None) -> None:
        super().__init__("ftc_controller", argv)
        self.p = declare(self, FtcParameters)

    def make(self) -> FtcCore:
        """Load the gains."""
        return FtcCore(self.p)

    def take(self, state: Any, said: list[Said]) -> bool:
        """Tell a change of mode or reason at once."""
        before = self.state
        done = super().take(state, said)
        if done and state.word != before.word:
            self.health.publish_status()
        return done

    def report(self) -> Report:
        """Health of the controller."""
        state, command = self.state, self.state.command
        mode, reason, status = command.mode.value, command.reason, NodeStatus.STATUS_OK
        why, stamp = state.unused
        if why and state.last.stamp - stamp < REMEMBERED:
            status = NodeStatus.STATUS_DEGRADED
            unused = f"{topics.ACCELERATION.name} is not used: {why}"
            reason = f"{reason}; {unused}" if reason else unused
        if command.mode is Mode.SAFE:
            status = NodeStatus.STATUS_LOST
        if not state.heard:
            status = NodeStatus.STATUS_INITIALIZING
            mode, reason = self.before_samples()
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
        self.publish(self.core.last_words(self.state, self.when()))


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
