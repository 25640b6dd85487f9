"""The fault-tolerant controller on messages: no node, no clock. Live and in replay the same messages give the same.

A sample is deflection and acceleration of one tick, whichever comes first. A fault estimate acts on samples that are
`SETTLED` younger, so that its own time of arrival changes nothing.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from copy import copy
from operator import itemgetter
from typing import Any, NamedTuple, TypeAlias

from er_common.common_parameters import silence
from er_common.stamps import SECOND, Checks, StampLimits, StampState, Verdict, counted
from er_models.files import load_model
from er_ros_common.builders import Tick
from er_ros_common.core import Core, Said, Shell, When, by_place, judged
from er_ros_common.health import Report
from er_ros_common.stuck import ACCELERATION, DEFLECTION, Watched, check

from er_common import topics
from er_damper_msgs.msg import FaultEstimate, NodeStatus, PwmDuty
from er_ftc_controller import control
from er_ftc_controller.align import Aligner
from er_ftc_controller.control import Command, Faults, Mode, Sample
from er_ftc_controller.gains import load_gains
from er_ftc_controller.opinion import opinion
from er_ftc_controller.programs import FTC
from er_ftc_controller.settings import FtcParameters, controller_of
from er_ros_common import builders

SETTLED = 0.02
"""Age at which a fault estimate acts [s]: above what messages are late by, far below what faults take."""
_SETTLED = round(1e9 * SETTLED)
REMEMBERED = SECOND
"""How long an acceleration that was not used is still said [ns]."""
WAITING = 64
"""Fault estimates kept until they act."""
HELD = 4
"""Applied duties kept until a sample asks which one acted before it."""
Waiting: TypeAlias = tuple[tuple[int, Faults], ...]
_SOURCE = {
    Mode.NOMINAL: PwmDuty.SOURCE_NOMINAL,
    Mode.FAULT_TOLERANT: PwmDuty.SOURCE_FTC,
    Mode.SAFE: PwmDuty.SOURCE_SAFE,
}
_USABLE = (FaultEstimate.STATUS_OK, FaultEstimate.STATUS_DEGRADED)


class State(NamedTuple):
    """What the controller knows; halves of samples; estimates that wait, oldest first, by stamp [ns].

    checks: of each input's stamps; body, strut: whether a sensor is stuck; last: the last sample; heard: when the last
    usable one came [ns, steady]; base: stamp of the first one; counts; silent: how `mind` goes on while samples stay
    away. The next sample finds `mind` as the last one left it, so that answers to samples do not depend on when
    somebody looked. unused: why an acceleration was not used, and the stamp of the last such. applied: duties by the
    stamp from which on they are in force, newest first.
    """

    mind: control.State
    pairs: Aligner[tuple[float, float], tuple[float, float]]
    body: Watched = Watched()
    strut: Watched = Watched()
    waiting: Waiting = ()
    checks: Checks = (StampState(),) * 4
    last: Tick = Tick(0, 0)
    heard: int = 0
    base: int = 0
    unusable: int = 0
    told: int = 0
    silent: control.State | None = None
    unused: tuple[str, int] = ("", 0)
    applied: tuple[tuple[int, float], ...] = ()

    @property
    def stamps(self) -> StampState:
        """Counts of all inputs."""
        return counted(self.checks)

    @property
    def command(self) -> Command:
        """What was said last."""
        return (self.silent or self.mind).command

    @property
    def word(self) -> tuple[Mode, str]:
        """Mode and why."""
        return self.command[1:3]


class FtcCore(Core):
    """Files are read here, and never again.

    Without a fault estimator the damper is taken for healthy; without applied duties a duty is as late as `latency`.
    """

    p: FtcParameters
    inputs = (topics.ACCELERATION, topics.DEFLECTION, topics.FAULT, topics.PWM_APPLIED)
    optional = (topics.FAULT, topics.PWM_APPLIED)
    outputs = (topics.PWM_COMMAND,)

    def __init__(self, p: FtcParameters) -> None:
        self.model = load_model(p.model_file)
        self.loaded = load_gains(p.gains_file, self.model)
        self.model_id, self.gains_id = self.model.digest(), self.loaded.digest
        self._take(p)

    def _take(self, p: FtcParameters) -> None:
        """Make the controller of model, gains and parameters."""
        self.p, self.controller = p, controller_of(p, self.model, self.loaded)
        sample = StampLimits(stale=p.max_age, gap=self.controller.rules.gap)
        # an estimate comes later than its tick where a part of that is waited for, and acts until it is old
        self.limits = (sample, sample, StampLimits(stale=p.fault_age), sample)
        rules, ahead = self.controller.rules, p.latency + p.ahead
        self.believed = rules.believed[1] / ahead if ahead else math.inf
        warm = control.start(self.controller)
        control.step(self.controller, warm, 0.0, Sample(0.0, 0.0, 0.0, 0.0))

    def tuned(self, p: FtcParameters) -> FtcCore:
        """With another controller of the same model and gains."""
        made = copy(self)
        made._take(p)
        return made

    def start(self) -> State:
        """Before any message."""
        return State(control.start(self.controller), Aligner())

    def on_message(
        self, state: State, topic: topics.Topic, message: Any, when: When
    ) -> tuple[State, list[Said]]:
        """Take a message of one of the inputs, if its stamp is good; what is to be published for it."""
        checks, verdict, (stamp, seq) = judged(self, state.checks, topic, message, when)
        if topic is topics.FAULT:
            waiting = _waiting(state.waiting, stamp, message, verdict)
            return state._replace(checks=checks, waiting=waiting), []
        if not verdict.use:
            return state._replace(checks=checks), []
        back = verdict is Verdict.JUMPED_BACK
        if topic is topics.PWM_APPLIED:
            held = () if back or not message.valid else state.applied[: HELD - 1]
            new = ((stamp, message.duty),) if message.valid else ()
            return state._replace(checks=checks, applied=(*new, *held)), []
        if topic is topics.ACCELERATION:
            value = (message.sprung, message.unsprung) if message.valid else (math.nan, math.nan)
            body, stuck = check(state.body, value, ACCELERATION, stamp)
            why = self._doubt(message) or ("stuck" if stuck else "")
            if why:
                # it leaves the sample without a force, not without a duty
                value, unusable = (math.nan, math.nan), state.unusable + 1
                state = state._replace(unused=(why, stamp), unusable=unusable)
            pairs, pair = state.pairs.with_left(stamp, value, back=back)
            state = state._replace(checks=checks, pairs=pairs, body=body)
        else:
            motion = (message.deflection, message.velocity)
            strut, stuck = check(state.strut, motion, DEFLECTION, stamp)
            if stuck or not (message.valid and message.velocity_valid):
                unusable = state.unusable + 1
                return state._replace(checks=checks, strut=strut, unusable=unusable), []
            pairs, pair = state.pairs.with_right(stamp, motion, back=back)
            state = state._replace(checks=checks, pairs=pairs, strut=strut)
        if pair is None:
            return state, []
        acted = next((duty for since, duty in state.applied if since < stamp), math.nan)
        sample = Sample(*pair[1], *pair[0], duty=acted)
        return self._sample(state, Tick(stamp, seq), sample, when)

    def _doubt(self, message: Any) -> str:
        """Why accelerations are not used; empty where they are.

        Those are beyond belief that would take the velocity over all that is believed while a duty is on its way.
        """
        if not message.valid:
            return "not valid"
        most = max(abs(message.sprung), abs(message.unsprung))
        if not math.isfinite(message.sprung + message.unsprung):
            return "not a number"
        return "beyond belief" if most > self.believed else ""

    def on_time(self, state: State, when: When) -> tuple[State, list[Said]]:
        """Go on without samples where they stay away, towards the safe duty."""
        since = silence(self.p, when.steady - state.heard)
        if not state.heard or since <= self.p.timeout:
            return state, []
        t = 1e-9 * (state.last.stamp - state.base) + since
        before = state.silent or state.mind
        silent, command = control.step(self.controller, before, t, None)
        if silent is before:
            return state, []
        tick = Tick(max(when.system or 0, state.last.stamp), state.last.seq)
        return state._replace(silent=silent), [_command(tick, command)]

    def last_words(self, state: State, when: When) -> list[Said]:
        """The safe duty, for somebody who stops the controller; without a simulated clock at the last sample."""
        command = state.command._replace(duty=self.p.safe_duty, mode=Mode.SAFE)
        return [_command(Tick(max(when.system or 0, state.last.stamp), state.last.seq), command)]

    def urgent(self, before: State, after: State) -> bool:
        """A change of mode or reason is said at once."""
        return before.word != after.word

    def report(self, state: State) -> Report:
        """Health of the controller."""
        command, heard = state.command, bool(state.heard)
        mode, reason, status = command.mode.value, command.reason, NodeStatus.STATUS_OK
        why, stamp = state.unused
        if why and state.last.stamp - stamp < REMEMBERED:
            status = NodeStatus.STATUS_DEGRADED
            unused = f"{topics.ACCELERATION.name} is not used: {why}"
            reason = f"{reason}; {unused}" if reason else unused
        if command.mode is Mode.SAFE:
            status = NodeStatus.STATUS_LOST
        if not heard:
            mode, status = "", NodeStatus.STATUS_INITIALIZING
        values = {
            "rho": f"{command.rho:.3f}",
            "force asked for [N]": f"{command.wanted:.2f}",
            "latency [ms]": f"{1e3 * control.latency(self.controller, state.mind.lateness):g}",
            "factors in use f1 f2 f3": " ".join(f"{f:.3f}" for f in command.left),
            "fault estimates": state.told,
            "halves without partner": state.pairs.unmatched,
        }
        valid = heard and command.mode is not Mode.SAFE
        return Report(mode, status, reason, state.stamps, state.unusable, valid, values)

    def _sample(
        self, state: State, tick: Tick, sample: Sample, when: When
    ) -> tuple[State, list[Said]]:
        """Answer a whole sample."""
        base = state.base or tick.stamp
        t = 1e-9 * (tick.stamp - base)
        mind, waiting = self._heard(state, base, tick.stamp)
        mind, command = control.step(self.controller, mind, t, sample)
        good = mind.heard == t
        heard, unusable = when.steady if good else state.heard, state.unusable + (not good)
        told = state.told + (waiting is not state.waiting)
        silent = None  # what was said while samples stayed away ends with the sample
        come = (state.pairs, state.body, state.strut, waiting, state.checks)
        rest = (tick, heard, base, unusable, told, silent, state.unused, state.applied)
        return by_place(State, (mind, *come, *rest)), [_command(tick, command)]

    def _heard(self, state: State, base: int, stamp: int) -> tuple[control.State, Waiting]:
        """The controller told the newest estimate that is old enough for a sample, and the later ones, which wait."""
        due = bisect_right(state.waiting, stamp - _SETTLED, key=itemgetter(0))
        if not due:
            return state.mind, state.waiting
        newest, faults = state.waiting[due - 1]  # of equal ones what was said last
        faults = Faults(1e-9 * (newest - base), *faults[1:])
        return control.hear(self.controller, state.mind, faults), state.waiting[due:]


def _waiting(before: Waiting, stamp: int, message: FaultEstimate, verdict: Verdict) -> Waiting:
    """Estimates that wait, oldest first, with one more; one of the same tick may take back what was said."""
    if not (verdict.use or verdict is Verdict.DUPLICATE):
        return before
    if verdict is Verdict.JUMPED_BACK:
        before = ()
    return (*before, (stamp, faults_of(message)))[-WAITING:]


def faults_of(message: FaultEstimate) -> Faults:
    """What a message says of the faults, but when; not valid, or something unexplained beside them: not to be used."""
    factors = (message.f1, message.f2, message.f3)
    states = (message.f1_status, message.f2_status, message.f3_status)
    trusted = message.valid and message.status in _USABLE and not message.unexplained
    return opinion(0.0, factors, states, trusted=trusted)


def _command(tick: Tick, command: Command) -> Said:
    """The message of a command."""
    safe = command.mode is Mode.SAFE
    status = PwmDuty.STATUS_LOST if safe else PwmDuty.STATUS_OK
    message = builders.pwm_duty(tick, command.duty, source=_SOURCE[command.mode], status=status)
    return topics.PWM_COMMAND, message


CORES = {
    FTC: Shell(
        FtcParameters,
        FtcCore,
        hears=FtcCore.inputs,
        says=FtcCore.outputs,
        period=0.005,
        whole=(topics.DEFLECTION,),
    )
}
