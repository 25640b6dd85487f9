"""The Skyhook controller node: answers every sample with a duty; see `er_ftc_controller.ros_skyhook`.

Where samples stay away it asks for the safe duty, and once more when it is stopped: the last
command is never the last thing that was right some time ago.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from er_ros_common.core_node import CoreNode
from er_ros_common.health import Report
from er_ros_common.help import Card
from er_ros_common.parameters import declare
from er_ros_common.spin import Executable, run

from er_damper_msgs.msg import NodeStatus
from er_ftc_controller.ros_skyhook import SkyhookCore, SkyhookParameters
from er_ros_common import topics


class SkyhookController(CoreNode):
    """The core with its health."""

    whole = (topics.DEFLECTION,)

    def __init__(self, argv: Sequence[str] | None = None) -> None:
        super().__init__("skyhook_controller", argv)
        self.p = declare(self, SkyhookParameters)

    def make(self) -> SkyhookCore:
        """Make the law."""
        return SkyhookCore(self.p)

    def report(self) -> Report:
        """Health of the controller."""
        s, mode, status, reason = self.state, "running", NodeStatus.STATUS_OK, ""
        if not s.heard:
            mode, reason = self.before_samples()
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
        self.publish(self.core.last_words(self.state, self.when()))


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
