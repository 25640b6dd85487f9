"""The shell that all observer nodes share; what it does with messages is `er_observers.ros_observer`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import partial

from er_ros_common.core_node import CoreNode
from er_ros_common.health import Report
from er_ros_common.help import Card
from er_ros_common.parameters import declare
from er_ros_common.spin import Executable
from std_msgs.msg import String

from er_damper_msgs.msg import NodeStatus
from er_observers.observers.status import LIMITS
from er_observers.ros_observer import ON_THE_WIRE, ObserverCore
from er_observers.running.runtime import payload_of
from er_observers.settings import ObserverParameters
from er_ros_common import qos, topics

GAIN_INFO = topics.Topic(
    "~/gain_info",
    String,
    "what the gains are and promise, JSON",
    0.0,
    *(topics.STATUS.publisher,) * 2,
)


class ObserverNode(CoreNode):
    """The core with its gains and its health.

    name: what its gains are kept under.
    """

    profile = qos.FOLLOWER
    watch_patience = LIMITS.bridge

    def __init__(self, name: str, argv: Sequence[str] | None = None) -> None:
        super().__init__(f"{name}_observer", argv)
        self.name = name
        self.p = declare(self, ObserverParameters)

    def make(self) -> ObserverCore:
        """Load model and gains, which must belong together."""
        return ObserverCore(self.name, self.p)

    def configure(self) -> None:
        """And say what the gains are."""
        super().configure()
        self.advertise(GAIN_INFO).publish(String(data=self._gain_info()))

    def _gain_info(self) -> str:
        g = self.core.gains
        return json.dumps(
            {"observer": g.observer, "gains": g.digest, "model": g.model, **g.figures}, default=str
        )

    def report(self) -> Report:
        """Health of the observer."""
        s = self.state
        mode, reason = self.before_samples()
        status = NodeStatus.STATUS_INITIALIZING
        values: dict[str, object] = {"duties lost": s.feed.lost}
        if self.core.gains.sees_deflection:
            values["deflections lost"] = s.feed.blind
        if s.mind is not None:
            mode, estimate = "running", s.mind.estimate
            status, reason = ON_THE_WIRE[estimate.status], estimate.reason
            values |= {"test ratio": f"{estimate.test_ratio:.2f}", "resets": s.mind.resets}
            payload = payload_of(self.core.gains, s.mind)
            values |= {"payload": payload.text, "sprung mass ratio": f"{payload.ratio:.3f}"}
            values["damping asymmetry"] = f"{payload.asymmetry:.3f}"
            if self.core.undriven(s.last.stamp, s.driven):
                reason = f"{topics.PWM_APPLIED.name}: no usable duty for {self.p.timeout:g} s"
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


def card(name: str, text: str) -> Card:
    """What the node called `name`_observer is, for its `--help`."""
    return Card(
        package="er_observers",
        executable=f"{name}_observer",
        text=text,
        parameters=ObserverParameters,
        subscribes=ObserverCore.usual,
        publishes=(topics.FORCE_BY[name], GAIN_INFO, topics.STATUS, topics.DIAGNOSTICS),
    )


def node_of(name: str, text: str) -> Executable:
    """The program of one observer; text: what it is, in a sentence."""
    return Executable(partial(ObserverNode, name), card(name, text))
