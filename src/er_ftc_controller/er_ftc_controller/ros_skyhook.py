"""Skyhook on messages: no node, no clock. Live and in replay the same messages give the same.

A sample is acceleration and deflection of one tick, whichever comes first; the law is `er_ftc_controller.skyhook`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from er_common.common_parameters import (
    FramedParameters,
    awaited_listeners,
    oldest_sample,
)
from er_common.parameter_table import REQUIRED, tuning
from er_common.stamps import Checks, StampLimits, StampState, Verdict, counted
from er_ros_common.builders import Tick
from er_ros_common.core import Core, Said, Shell, When, judged
from er_ros_common.health import Report
from er_ros_common.stuck import ACCELERATION, DEFLECTION, Watched, check

from er_common import topics
from er_damper_msgs.msg import NodeStatus, PwmDuty
from er_ftc_controller import ros_safe, skyhook
from er_ftc_controller.align import Aligner
from er_ftc_controller.programs import SKYHOOK
from er_ros_common import builders

GAP = StampLimits().gap
"""Longest gap between samples over which the velocity is carried [s]."""


@dataclass(frozen=True, kw_only=True)
class SkyhookParameters(FramedParameters):
    """Parameters of the node."""

    u_min: float = tuning(
        REQUIRED, low=0.0, high=1.0, text="duty where more damping would accelerate the body"
    )
    u_max: float = tuning(REQUIRED, low=0.0, high=1.0, text="duty where damping brakes the body")
    safe_duty: float = tuning(REQUIRED, low=0.0, high=1.0, text="duty without usable samples")
    corner_frequency: float = tuning(
        REQUIRED,
        unit="Hz",
        low=0.001,
        high=5.0,
        text="corner frequency of the leaky integral that gives the body's velocity",
    )
    timeout: float = tuning(
        0.025,
        unit="s",
        low=0.005,
        high=1.0,
        text="silence of the inputs after which it goes to the safe duty",
    )
    max_age: float = oldest_sample()
    listeners: int = awaited_listeners()


class State(NamedTuple):
    """State of the law, halves of samples, checks of each input's stamps.

    last: the last sample, heard: when [ns, steady], 0 before the first; safe: whether the safe duty is asked
    for, safe_at: when it was last [ns, steady]; unusable: samples that were not valid; body, strut: whether a sensor is
    stuck.
    """

    mind: skyhook.State = skyhook.START
    pairs: Aligner[float, float] = Aligner()
    checks: Checks = (StampState(),) * 2
    last: Tick = Tick(0, 0)
    heard: int = 0
    safe: bool = False
    safe_at: int = 0
    unusable: int = 0
    body: Watched = Watched()
    strut: Watched = Watched()

    @property
    def stamps(self) -> StampState:
        """Counts of both inputs."""
        return counted(self.checks)


class SkyhookCore(Core):
    """Joins acceleration and deflection of a tick and answers with a duty.

    Where samples stay away it asks for the safe duty, and once more when it is stopped: the last
    command is never the last thing that was right some time ago.
    """

    p: SkyhookParameters
    inputs = (topics.ACCELERATION, topics.DEFLECTION)
    outputs = (topics.PWM_COMMAND,)

    def __init__(self, p: SkyhookParameters) -> None:
        self.p = p
        self.law = skyhook.Skyhook(p.u_min, p.u_max, p.corner_frequency, gap=GAP)
        self.limits = (StampLimits(stale=p.max_age, gap=GAP),) * len(self.inputs)

    def tuned(self, p: SkyhookParameters) -> SkyhookCore:
        """Made anew, as nothing is read."""
        return SkyhookCore(p)

    def start(self) -> State:
        """Before any message."""
        return State()

    def on_message(
        self, state: State, topic: topics.Topic, message: Any, when: When
    ) -> tuple[State, list[Said]]:
        """Take half of a sample, if its stamp is good."""
        acceleration = topic is topics.ACCELERATION
        checks, verdict, (stamp, seq) = judged(self, state.checks, topic, message, when)
        state, back = state._replace(checks=checks), verdict is Verdict.JUMPED_BACK
        if not verdict.use:
            return state, []
        if not (message.valid and (acceleration or message.velocity_valid)):
            return state._replace(unusable=state.unusable + 1), []
        if acceleration:
            body, stuck = check(
                state.body, (message.sprung, message.unsprung), ACCELERATION, stamp
            )
            state = state._replace(body=body)
        else:
            strut, stuck = check(
                state.strut, (message.deflection, message.velocity), DEFLECTION, stamp
            )
            state = state._replace(strut=strut)
        if stuck:
            return state._replace(unusable=state.unusable + 1), []
        if acceleration:
            pairs, pair = state.pairs.with_left(stamp, message.sprung, back=back)
        else:
            pairs, pair = state.pairs.with_right(stamp, message.velocity, back=back)
        state = state._replace(pairs=pairs)
        if pair is None:
            return state, []
        return self._answered(state, Tick(stamp, seq), pair, when)

    def on_time(self, state: State, when: When) -> tuple[State, list[Said]]:
        """Ask for the safe duty while the inputs are silent."""
        if not ros_safe.due(self.p, state.heard, state.safe_at, when):
            return state, []
        return state._replace(safe=True, safe_at=when.steady), self.last_words(state, when)

    def last_words(self, state: State, when: When) -> list[Said]:
        """The safe duty, from now on; in simulated time without a clock, from the last sample on."""
        message = ros_safe.message(self.p.safe_duty, state.last, when)
        return [(topics.PWM_COMMAND, message)]

    def report(self, state: State) -> Report:
        """Health of the controller."""
        s, mode, status, reason = state, "running", NodeStatus.STATUS_OK, ""
        if not s.heard:
            mode, status = "", NodeStatus.STATUS_INITIALIZING
        elif s.safe:
            mode, status = "safe", NodeStatus.STATUS_LOST
            reason = f"no usable sample for {self.p.timeout:g} s: safe duty"
        values = {
            "sprung velocity [m/s]": f"{s.mind.velocity:.4f}",
            "halves without partner": s.pairs.unmatched,
        }
        return Report(mode, status, reason, s.stamps, s.unusable, mode == "running", values)

    def _answered(
        self, state: State, tick: Tick, pair: tuple[float, float], when: When
    ) -> tuple[State, list[Said]]:
        """Answer one sample."""
        sample = skyhook.Sample(1e-9 * tick.stamp, *pair)
        if not skyhook.usable(sample):
            return state._replace(unusable=state.unusable + 1), []
        mind, command = skyhook.step(self.law, state.mind, sample)
        state = state._replace(mind=mind, last=tick, safe=False, heard=when.steady)
        message = builders.pwm_duty(tick, command.duty, source=PwmDuty.SOURCE_NOMINAL)
        return state, [(topics.PWM_COMMAND, message)]


CORES = {
    SKYHOOK: Shell(
        SkyhookParameters,
        SkyhookCore,
        hears=SkyhookCore.inputs,
        says=SkyhookCore.outputs,
        whole=(topics.DEFLECTION,),
    )
}
