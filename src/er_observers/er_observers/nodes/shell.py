"""The shell that all observer nodes share; the estimate is `er_observers.observers.runtime`."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from time import monotonic, perf_counter

from er_models.errors import InputError
from er_models.files import load_model
from er_ros_common.builders import Tick
from er_ros_common.clock import from_stamp, now
from er_ros_common.common_parameters import NodeParameters, awaited_listeners, oldest_sample
from er_ros_common.graph_check import connected
from er_ros_common.health import Report
from er_ros_common.help import Card
from er_ros_common.managed import ManagedNode
from er_ros_common.parameters import REQUIRED, declare, param
from er_ros_common.spin import Executable
from er_ros_common.stamps import StampLimits, StampState, check_stamp
from std_msgs.msg import String

from er_damper_msgs.msg import DamperForce, NodeStatus, PwmDuty, SuspensionAcceleration
from er_observers.gains import Gains
from er_observers.nodes.feed import Feed, Joined, Motion, on_duty, on_motion
from er_observers.observers import runtime as observer
from er_observers.observers.ready import ready
from er_observers.observers.status import Status
from er_ros_common import builders, qos, topics

GAIN_INFO = topics.Topic(
    "~/gain_info",
    String,
    "what the gains are and promise, JSON",
    0.0,
    *(topics.STATUS.publisher,) * 2,
)
INPUTS = (topics.ACCELERATION, topics.PWM_APPLIED)
WATCH_PERIOD = 0.05
_ON_THE_WIRE = {
    Status.OK: DamperForce.STATUS_OK,
    Status.INITIALISING: DamperForce.STATUS_INITIALIZING,
    Status.DEGRADED: DamperForce.STATUS_DEGRADED,
    Status.WEAK: DamperForce.STATUS_DEGRADED,
    Status.INVALID: DamperForce.STATUS_LOST,
}


@dataclass(frozen=True, kw_only=True)
class ObserverParameters(NodeParameters):
    """Parameters of the node."""

    model_file: str = param(REQUIRED, text="model of the vehicle the gains were made for")
    gains_file: str = param(REQUIRED, text="gains of this observer for this model")
    timeout: float = param(
        0.05, unit="s", low=0.005, high=1.0, text="silence after which the estimate is not valid"
    )
    max_age: float = oldest_sample()
    listeners: int = awaited_listeners()


class ObserverNode(ManagedNode):
    """Estimates the damper force at every sample of the accelerations.

    observer: name its gains are kept under; topic: where the force goes.
    """

    def __init__(self, name: str, topic: topics.Topic, argv: Sequence[str] | None = None) -> None:
        super().__init__(f"{name}_observer", argv)
        self.name, self.topic = name, topic
        self.p = declare(self, ObserverParameters)

    def configure(self) -> None:
        """Load model and gains, which must belong together, and make the ends."""
        p = self.p
        model = load_model(p.model_file)
        self.gains = ready(p.gains_file, model, self.name)
        refuse_deflection(p.gains_file, self.gains)
        self.limits = StampLimits(stale=p.max_age, gap=p.timeout)
        self.health.model_id, self.health.gains_id = model.digest(), self.gains.digest
        self.force = self.advertise(self.topic)
        self.advertise(GAIN_INFO).publish(String(data=self._gain_info()))
        heard = (self.on_acceleration, self.on_applied)
        self.inputs = [
            self.subscribe(topic, callback, qos.FOLLOWER)
            for topic, callback in zip(INPUTS, heard, strict=True)
        ]
        self.every(WATCH_PERIOD, self.on_watch)

    def begin(self) -> None:
        """Know nothing yet."""
        self.feed, self.stamps, self.base = Feed(), StampState(), 0
        self.state: observer.State | None = None
        self.last, self.heard_at, self.unusable, self.silent = Tick(0, 0), 0.0, 0, False

    def _gain_info(self) -> str:
        g = self.gains
        return json.dumps(
            {"observer": g.observer, "gains": g.digest, "model": g.model, **g.figures}, default=str
        )

    def on_acceleration(self, message: SuspensionAcceleration) -> None:
        """Take one sample, if its stamp is good; values that are not valid are bridged."""
        stamp, seq = from_stamp(message.header.stamp), int(message.seq)
        arrival = now(self) if self.p.max_age else None
        self.stamps, verdict = check_stamp(self.limits, self.stamps, stamp, seq, arrival)
        if not verdict.use:
            return
        good = message.valid and math.isfinite(message.sprung) and math.isfinite(message.unsprung)
        self.unusable += not good
        values = (message.sprung, message.unsprung) if good else (math.nan, math.nan)
        self.feed, ready = on_motion(self.feed, Motion(stamp, seq, *values))
        self.estimate(ready)

    def on_applied(self, message: PwmDuty) -> None:
        """Take the duty in force from now on."""
        duty = message.duty if message.valid else math.nan
        self.feed, ready = on_duty(self.feed, from_stamp(message.header.stamp), duty)
        self.estimate(ready)

    def estimate(self, ready: list[Joined]) -> None:
        """Step and publish for each sample that is complete."""
        for motion, duty in ready:
            began = perf_counter()
            self.base = self.base or motion.stamp
            t = 1e-9 * (motion.stamp - self.base)
            sample = observer.Sample(t, motion.sprung, motion.unsprung, duty)
            if self.state is None:
                self.state = observer.start(self.gains, sample)
                estimate = self.state.estimate
            else:
                self.state, estimate = observer.step(self.gains, self.state, sample)
            self.last, self.heard_at, self.silent = Tick(*motion[:2]), monotonic(), False
            self.publish(self.last, estimate)
            self.health.meter.step(perf_counter() - began)

    def publish(self, tick: Tick, e: observer.Estimate) -> None:
        """Publish one estimate with the stamp of its sample."""
        message = builders.damper_force(
            tick,
            e.force,
            test_ratio=e.test_ratio,
            status=_ON_THE_WIRE[e.status],
            valid=e.status is not Status.INVALID,
        )
        self.force.publish(message)

    def on_watch(self) -> None:
        """Say once that the estimate is no longer valid when the samples stay away."""
        if not self.heard_at or self.silent:
            return
        if monotonic() - self.heard_at > self.p.timeout:
            self.silent = True
            message = builders.damper_force(
                self.last, 0.0, status=DamperForce.STATUS_LOST, valid=False
            )
            self.force.publish(message)

    def report(self) -> Report:
        """Health of the observer."""
        ready = connected(self.inputs, [(self.force, self.p.listeners)])
        mode, reason = ("ready", "no sample yet") if ready else ("waiting", "not connected yet")
        status = NodeStatus.STATUS_INITIALIZING
        values: dict[str, object] = {"duties lost": self.feed.lost}
        if self.state is not None:
            mode, estimate = "running", self.state.estimate
            status, reason = _ON_THE_WIRE[estimate.status], estimate.reason
            values |= {"test ratio": f"{estimate.test_ratio:.2f}", "resets": self.state.resets}
        if self.silent:
            mode, status = "silent", NodeStatus.STATUS_LOST
            reason = f"no sample for {self.p.timeout:g} s"
        return Report(
            mode,
            status,
            reason,
            stamps=self.stamps,
            invalid=self.unusable,
            valid=mode == "running" and status != NodeStatus.STATUS_LOST,
            values=values,
        )


def refuse_deflection(path: str, gains: Gains) -> None:
    """Raise `InputError` for gains that need a sensor which the node does not listen to."""
    if gains.sees_deflection:
        raise InputError(path, "model.outputs", "two accelerations", "the deflection as well")


def card(name: str, topic: topics.Topic, text: str) -> Card:
    """What the node called `name`_observer is, for its `--help`."""
    return Card(
        package="er_observers",
        executable=f"{name}_observer",
        text=text,
        parameters=ObserverParameters,
        subscribes=INPUTS,
        publishes=(topic, GAIN_INFO, topics.STATUS, topics.DIAGNOSTICS),
    )


def node_of(name: str, topic: topics.Topic, text: str) -> Executable:
    """The program of one observer."""
    return Executable(partial(ObserverNode, name, topic), card(name, topic, text))
