"""The fault estimator node; what it does with messages is `er_observers.ros_faults`."""

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
from er_observers.fault_settings import FaultParameters
from er_observers.ros_faults import ON_THE_WIRE, FaultCore
from er_ros_common import qos, topics

NAME = "fault_estimator"
TEXT = (
    "What faults have left of the damper (f1 electrical, f2 leakage, f3 deformation), and which fault it is: "
    "from accelerations, deflection and duty."
)
WATCH_PERIOD = 0.05


class FaultNode(ManagedNode):
    """Gives messages to the core and publishes what it says."""

    def __init__(self, argv: Sequence[str] | None = None) -> None:
        super().__init__(NAME, argv)
        self.p = declare(self, FaultParameters)

    def configure(self) -> None:
        """Load the model and make the ends."""
        self.core = FaultCore(self.p)
        self.health.model_id = self.core.model_id
        self.faults = self.advertise(topics.FAULT)
        self.inputs = [
            self.subscribe(topic, partial(self.on_message, topic), qos.FOLLOWER)
            for topic in self.core.inputs
        ]
        self.every(WATCH_PERIOD, self.on_watch)

    def begin(self) -> None:
        """Know nothing yet."""
        self.state = self.core.start()

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
            self.faults.publish(message)

    def report(self) -> Report:
        """Health of the estimator."""
        s = self.state
        ready = connected(self.inputs, [(self.faults, self.p.listeners)])
        mode, reason = ("ready", "no sample yet") if ready else ("waiting", "not connected yet")
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
