"""The fault estimator node; what it does with messages is `er_observers.ros_faults`."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from er_ros_common.core_node import CoreNode
from er_ros_common.health import Report
from er_ros_common.help import Card
from er_ros_common.parameters import declare
from er_ros_common.spin import Executable, run

from er_damper_msgs.msg import NodeStatus
from er_observers.fault_settings import FaultParameters
from er_observers.ros_faults import ON_THE_WIRE, FaultCore
from er_ros_common import qos, topics

NAME = "fault_estimator"
TEXT = (
    "What faults have left of the damper (f1 electrical, f2 leakage, f3 deformation), and which fault it is: "
    "from accelerations, deflection and duty."
)


class FaultNode(CoreNode):
    """The core with its health."""

    watch_period, profile, whole = 0.05, qos.FOLLOWER, (topics.DEFLECTION,)

    def __init__(self, argv: Sequence[str] | None = None) -> None:
        super().__init__(NAME, argv)
        self.p = declare(self, FaultParameters)

    def make(self) -> FaultCore:
        """Load the model."""
        return FaultCore(self.p)

    def report(self) -> Report:
        """Health of the estimator."""
        s = self.state
        mode, reason = self.before_samples()
        status = NodeStatus.STATUS_INITIALIZING
        values: dict[str, object] = {"parts lost": s.gathered.missing}
        if s.mind is not None:
            mode, e = "running", s.mind.estimate
            status, reason = ON_THE_WIRE[e.status], e.reason
            values |= {"fault": e.kind.name.lower(), "certainty": f"{e.certainty:.3f}"}
            values |= {"test ratio": f"{e.test_ratio:.2f}", "resets": s.mind.resets}
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


CARD = Card(
    package="er_observers",
    executable=NAME,
    text=TEXT,
    parameters=FaultParameters,
    subscribes=(topics.ACCELERATION, topics.DEFLECTION, topics.PWM_APPLIED, topics.FORCE),
    publishes=(topics.FAULT, topics.STATUS, topics.DIAGNOSTICS),
)
NODE = Executable(FaultNode, CARD)


def main() -> None:
    """Entry point of the executable."""
    sys.exit(run(NODE.make, NODE.card))


if __name__ == "__main__":
    main()
