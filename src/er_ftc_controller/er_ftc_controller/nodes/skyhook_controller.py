"""The Skyhook controller node: answers every sample with a duty; see `er_ftc_controller.skyhook`.

Where samples stay away it asks for the safe duty, and once more when it is stopped: the last
command is never the last thing that was right some time ago.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from time import monotonic, perf_counter

from er_ros_common.builders import Tick
from er_ros_common.clock import from_stamp, now
from er_ros_common.common_parameters import NodeParameters, awaited_listeners, oldest_sample
from er_ros_common.graph_check import connected
from er_ros_common.health import Report
from er_ros_common.help import Card
from er_ros_common.managed import ManagedNode
from er_ros_common.parameters import REQUIRED, declare, param
from er_ros_common.spin import Executable, run
from er_ros_common.stamps import StampLimits, StampState, check_stamp

from er_damper_msgs.msg import NodeStatus, PwmDuty, SuspensionAcceleration, SuspensionDeflection
from er_ftc_controller import skyhook
from er_ftc_controller.align import Aligner
from er_ros_common import builders, topics

WATCH_PERIOD = 0.01
"""How often the silence of the inputs is looked at [s]."""
REPEAT = 0.05
"""How often the safe duty is asked for again [s]."""
INPUTS = (topics.ACCELERATION, topics.DEFLECTION)


@dataclass(frozen=True, kw_only=True)
class SkyhookParameters(NodeParameters):
    """Parameters of the node."""

    u_min: float = param(REQUIRED, low=0.0, high=1.0, text="duty where field would push the body")
    u_max: float = param(REQUIRED, low=0.0, high=1.0, text="duty where field brakes the body")
    safe_duty: float = param(REQUIRED, low=0.0, high=1.0, text="duty without usable samples")
    corner_frequency: float = param(
        REQUIRED, unit="Hz", low=0.001, high=5.0, text="leak of the velocity integral"
    )
    timeout: float = param(
        0.05, unit="s", low=0.005, high=1.0, text="silence of the inputs that makes it safe"
    )
    max_age: float = oldest_sample()
    listeners: int = awaited_listeners()


class SkyhookController(ManagedNode):
    """Joins acceleration and deflection of a tick and publishes the duty for it."""

    def __init__(self, argv: Sequence[str] | None = None) -> None:
        super().__init__("skyhook_controller", argv)
        self.p = declare(self, SkyhookParameters)

    def configure(self) -> None:
        """Make the law and the ends."""
        p = self.p
        self.law = skyhook.Skyhook(p.u_min, p.u_max, p.corner_frequency, gap=p.timeout)
        self.limits = StampLimits(stale=p.max_age, gap=p.timeout)
        self.command = self.advertise(topics.PWM_COMMAND)
        heard = (self.on_acceleration, self.on_deflection)
        self.inputs = [
            self.subscribe(topic, callback) for topic, callback in zip(INPUTS, heard, strict=True)
        ]
        self.every(WATCH_PERIOD, self.on_watch)

    def begin(self) -> None:
        """Know nothing yet."""
        self.state, self.stamps = skyhook.START, StampState()
        self.pairs: Aligner[float, float] = Aligner()
        self.unusable, self.safe, self.last, self.heard_at = 0, False, Tick(0, 0), 0.0
        self.safe_at = 0.0

    def on_acceleration(self, message: SuspensionAcceleration) -> None:
        """Half of a sample."""
        if not message.valid:
            self.unusable += 1
            return
        stamp = from_stamp(message.header.stamp)
        self.pairs, pair = self.pairs.with_left(stamp, message.sprung)
        if pair is not None:
            self.on_sample(Tick(stamp, message.seq), *pair)

    def on_deflection(self, message: SuspensionDeflection) -> None:
        """The other half."""
        if not (message.valid and message.velocity_valid):
            self.unusable += 1
            return
        stamp = from_stamp(message.header.stamp)
        self.pairs, pair = self.pairs.with_right(stamp, message.velocity)
        if pair is not None:
            self.on_sample(Tick(stamp, message.seq), *pair)

    def on_sample(self, tick: Tick, acceleration: float, velocity: float) -> None:
        """Answer one sample."""
        began = perf_counter()
        arrival = now(self) if self.p.max_age else None
        self.stamps, verdict = check_stamp(self.limits, self.stamps, tick.stamp, tick.seq, arrival)
        sample = skyhook.Sample(1e-9 * tick.stamp, acceleration, velocity)
        if not verdict.use or not skyhook.usable(sample):
            self.unusable += verdict.use
            return
        self.state, command = skyhook.step(self.law, self.state, sample)
        self.last, self.safe, self.heard_at = tick, False, monotonic()
        duty = builders.pwm_duty(tick, command.duty, source=PwmDuty.SOURCE_NOMINAL)
        self.command.publish(duty)
        self.health.meter.step(perf_counter() - began)

    def on_watch(self) -> None:
        """Ask for the safe duty while the inputs are silent."""
        silent = monotonic() - self.heard_at > self.p.timeout
        if self.heard_at and silent and monotonic() - self.safe_at > REPEAT:
            self.safe, self.safe_at = True, monotonic()
            self.publish_safe()

    def publish_safe(self) -> None:
        """The safe duty, from now on."""
        message = builders.pwm_duty(
            Tick(max(now(self), self.last.stamp), self.last.seq),
            self.p.safe_duty,
            source=PwmDuty.SOURCE_SAFE,
            status=PwmDuty.STATUS_LOST,
        )
        self.command.publish(message)

    def report(self) -> Report:
        """Health of the controller."""
        mode, status, reason = "running", NodeStatus.STATUS_OK, ""
        if not self.heard_at:
            ready = connected(self.inputs, [(self.command, self.p.listeners)])
            mode, reason = (
                ("ready", "no sample yet") if ready else ("waiting", "not connected yet")
            )
            status = NodeStatus.STATUS_INITIALIZING
        elif self.safe:
            mode, status = "safe", NodeStatus.STATUS_LOST
            reason = f"no usable sample for {self.p.timeout:g} s: safe duty"
        values = {
            "sprung velocity [m/s]": f"{self.state.velocity:.4f}",
            "halves without partner": self.pairs.unmatched,
        }
        return Report(
            mode,
            status,
            reason,
            stamps=self.stamps,
            invalid=self.unusable,
            valid=mode == "running",
            values=values,
        )

    def end(self) -> None:
        """Leave the safe duty behind."""
        self.publish_safe()


CARD = Card(
    package="er_ftc_controller",
    executable="skyhook_controller",
    text="Two-state Skyhook (3.81): full field where the damper brakes the body.",
    parameters=SkyhookParameters,
    subscribes=INPUTS,
    publishes=(topics.PWM_COMMAND, topics.STATUS, topics.DIAGNOSTICS),
)


NODE = Executable(SkyhookController, CARD)


def main() -> None:
    """Entry point of the executable."""
    sys.exit(run(SkyhookController, CARD))


if __name__ == "__main__":
    main()
