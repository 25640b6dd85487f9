"""The body controller on messages: a sample is one tick of all four corners, answered by four duties."""

from __future__ import annotations

import math
from copy import copy
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from er_common.common_parameters import (
    FramedParameters,
    awaited_listeners,
    oldest_sample,
)
from er_common.parameter_table import REQUIRED, param, tuning
from er_common.stamps import Checks, StampLimits, StampState, Verdict, counted
from er_common.topics import ACCELERATION, DEFLECTION, PWM_COMMAND, Topic, below
from er_models.car.body import CORNERS
from er_models.car.files import load_car
from er_models.own import effects
from er_ros_common.builders import Tick
from er_ros_common.core import Core, Said, Shell, When, judged
from er_ros_common.core_node import main as run
from er_ros_common.core_node import node_of
from er_ros_common.health import Report
from er_ros_common.stuck import Watched, check

from er_damper_msgs.msg import NodeStatus, PwmDuty
from er_ftc_controller import body, ros_safe
from er_ftc_controller.body_gains import load_body_gain
from er_ftc_controller.programs import BODY
from er_ros_common import builders, stuck

GAP = StampLimits().gap
"""Longest gap between samples over which the body's velocities are carried [s]."""


@dataclass(frozen=True, kw_only=True)
class BodyParameters(FramedParameters):
    """Parameters of the node."""

    car_file: str = param(REQUIRED, text="the car: body and four corners")
    effects_from: tuple[str, ...] = param(
        (), text="Python files with own effects that the corners use"
    )
    gains_file: str = param(REQUIRED, text="gain of er synth body_lqr for this car")
    u_min: float = tuning(0.0, low=0.0, high=1.0, text="least duty")
    u_max: float = tuning(REQUIRED, low=0.0, high=1.0, text="greatest duty")
    safe_duty: float = tuning(REQUIRED, low=0.0, high=1.0, text="duty without usable samples")
    horizon: float = tuning(
        0.02,
        unit="s",
        low=0.001,
        high=1.0,
        text="time within which a damper force is to be reached",
    )
    corner_frequency: float = tuning(
        0.1,
        unit="Hz",
        low=0.001,
        high=5.0,
        text="corner of the leaky integrals that give the body's velocities",
    )
    timeout: float = tuning(
        0.025,
        unit="s",
        low=0.005,
        high=1.0,
        text="silence of a corner after which all go to the safe duty",
    )
    max_age: float = oldest_sample()
    listeners: int = awaited_listeners()


class State(NamedTuple):
    """State of the law, the parts of the newest tick, checks of each input's stamps.

    parts: two numbers of each input, (8, 2), NaN where not yet there, of the tick at `stamp` [ns]. last: the last
    sample, heard: when [ns, steady], 0 before the first; safe: whether the safe duty is asked for, safe_at: when it was
    last [ns, steady]; unusable: parts that were not valid; watched: whether a sensor is stuck.
    """

    mind: body.BodyState
    checks: Checks
    watched: tuple[Watched, ...]
    parts: tuple[tuple[float, float], ...] = ((math.nan, math.nan),) * 8
    stamp: int = 0
    last: Tick = Tick(0, 0)
    heard: int = 0
    safe: bool = False
    safe_at: int = 0
    unusable: int = 0
    unmatched: int = 0


class BodyCore(Core):
    """Joins accelerations and deflections of all corners and answers with four duties, or with the safe one."""

    p: BodyParameters
    inputs = (*(below(ACCELERATION, c) for c in CORNERS), *(below(DEFLECTION, c) for c in CORNERS))
    outputs = tuple(below(PWM_COMMAND, c) for c in CORNERS)

    def __init__(self, p: BodyParameters) -> None:
        self.car = load_car(p.car_file, effects(p.effects_from))
        self.gain, self.gains_id = load_body_gain(p.gains_file, self.car)
        self.model_id = self.car.corners[0].digest()
        self._take(p)

    def _take(self, p: BodyParameters) -> None:
        """Make the law of car, gain and parameters."""
        limits = (p.u_min, p.u_max)
        law = body.law_of(self.car, self.gain, limits, p.horizon, p.corner_frequency)
        self.p, self.law = p, replace(law, gap=GAP)
        self.limits = (StampLimits(stale=p.max_age, gap=GAP),) * len(self.inputs)

    def tuned(self, p: BodyParameters) -> BodyCore:
        """With another law of the same car and gain."""
        made = copy(self)
        made._take(p)
        return made

    def start(self) -> State:
        """Before any message."""
        n = len(self.inputs)
        return State(body.start(), (StampState(),) * n, (Watched(),) * n)

    def on_message(
        self, state: State, topic: Topic, message: Any, when: When
    ) -> tuple[State, list[Said]]:
        """Take a part of a sample, if its stamp is good."""
        checks, verdict, (stamp, seq) = judged(self, state.checks, topic, message, when)
        state, which = state._replace(checks=checks), self.inputs.index(topic)
        if not verdict.use:
            return state, []
        of_mass = which < len(CORNERS)
        if of_mass:
            part, kind, whole = (
                (message.sprung, message.unsprung),
                stuck.ACCELERATION,
                message.valid,
            )
        else:
            part, kind = (message.deflection, message.velocity), stuck.DEFLECTION
            whole = message.valid and message.velocity_valid
        watched, hangs = check(state.watched[which], part, kind, stamp)
        row = state.watched
        state = state._replace(watched=(*row[:which], watched, *row[which + 1 :]))
        if hangs or not whole:
            return state._replace(unusable=state.unusable + 1), []
        if stamp != state.stamp:
            if stamp < state.stamp and verdict is not Verdict.JUMPED_BACK:
                return state._replace(unmatched=state.unmatched + 1), []
            unmatched = state.unmatched + any(math.isfinite(a) for a, _ in state.parts)
            state = state._replace(
                stamp=stamp, parts=State._field_defaults["parts"], unmatched=unmatched
            )
        parts = (*state.parts[:which], part, *state.parts[which + 1 :])
        state = state._replace(parts=parts)
        if any(math.isnan(a) for a, _ in parts):
            return state, []
        return self._answered(
            state._replace(parts=State._field_defaults["parts"]), parts, Tick(stamp, seq), when
        )

    def _answered(
        self, state: State, parts: tuple[tuple[float, float], ...], tick: Tick, when: When
    ) -> tuple[State, list[Said]]:
        """Answer one sample of all corners."""
        first, second = np.array(parts).T.reshape(2, 2, len(CORNERS))
        sample = body.BodySample(1e-9 * tick.stamp, first[1], second[1], first[0], second[0])
        if not body.usable(sample):
            return state._replace(unusable=state.unusable + 1), []
        mind, duties = body.step(self.law, state.mind, sample)
        state = state._replace(mind=mind, last=tick, safe=False, heard=when.steady)
        return state, [
            (topic, builders.pwm_duty(tick, duty, source=PwmDuty.SOURCE_NOMINAL))
            for topic, duty in zip(self.outputs, duties.tolist())
        ]

    def on_time(self, state: State, when: When) -> tuple[State, list[Said]]:
        """Ask for the safe duty while a corner is silent."""
        if not ros_safe.due(self.p, state.heard, state.safe_at, when):
            return state, []
        return state._replace(safe=True, safe_at=when.steady), self.last_words(state, when)

    def last_words(self, state: State, when: When) -> list[Said]:
        """The safe duty, from now on."""
        message = ros_safe.message(self.p.safe_duty, state.last, when)
        return [(topic, message) for topic in self.outputs]

    def report(self, state: State) -> Report:
        """Health of the controller."""
        mode, status, reason = "running", NodeStatus.STATUS_OK, ""
        if not state.heard:
            mode, status = "", NodeStatus.STATUS_INITIALIZING
        elif state.safe:
            mode, status = "safe", NodeStatus.STATUS_LOST
            reason = f"no usable sample of all corners for {self.p.timeout:g} s: safe duty"
        heave, roll, pitch = state.mind.rates.tolist()
        values = {
            "heave rate [m/s]": f"{heave:.4f}", "roll rate [rad/s]": f"{roll:.4f}", "pitch rate [rad/s]":
            f"{pitch:.4f}", "ticks without all corners": state.unmatched,
        }  # fmt: skip
        stamps = counted(state.checks)
        return Report(mode, status, reason, stamps, state.unusable, mode == "running", values)


CORES = {
    BODY: Shell(
        BodyParameters,
        BodyCore,
        hears=BodyCore.inputs,
        says=BodyCore.outputs,
        whole=BodyCore.inputs[len(CORNERS) :],
    )
}
NODE = node_of(BODY)
main = partial(run, BODY)
