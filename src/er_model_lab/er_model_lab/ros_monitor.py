"""The monitor on messages: no node, no clock. Live and in replay the same messages give the same.

What is computed is `er_model_lab.monitor`.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple

from er_common.common_parameters import silence
from er_common.gather import Gathered
from er_common.stamps import Checks, StampLimits, StampState, counted
from er_models.errors import InputError
from er_models.files import load_model
from er_ros_common.builders import Tick
from er_ros_common.core import Core, Said, Shell, When, by_place, judged
from er_ros_common.health import Report
from er_ros_common.parts import part_of
from er_ros_common.stuck import Watched

from er_common import gather, quality, topics
from er_damper_msgs.msg import DamperForce, NodeStatus
from er_model_lab.monitor import compare
from er_model_lab.monitor.compare import Answer, Row, monitor, row_of
from er_model_lab.monitor.sequential import HOUR, RULES, Rules
from er_model_lab.monitor.settings import MonitorParameters
from er_model_lab.monitor.watch import Finding, Watch
from er_model_lab.programs import MONITOR
from er_ros_common import builders

USUAL = (topics.ACCELERATION, topics.DEFLECTION, topics.PWM_APPLIED)
NEEDED = (gather.ACCELERATION, gather.DEFLECTION, gather.DUTY, gather.FORCE)
_STATUS = {
    Finding.LEARNING: DamperForce.STATUS_INITIALIZING,
    Finding.EXPLAINS: DamperForce.STATUS_OK,
    Finding.FAILS: DamperForce.STATUS_DEGRADED,
}


class State(NamedTuple):
    """Ticks that wait for a part, checks of each input's stamps, sensors, messages of no use, and the damper.

    rows: what the last message completed; last: the tick that was answered last, heard: when [ns, steady]; silent:
    whether it was said that samples stay away.
    """

    gathered: Gathered = Gathered()
    checks: Checks = ()
    sensors: tuple[Watched, Watched] = (Watched(), Watched())
    unusable: int = 0
    mind: compare.State = compare.State()
    rows: tuple[Row, ...] = ()
    last: Tick = Tick(0, 0)
    heard: int = 0
    silent: bool = False


class MonitorCore(Core):
    """The model file is read here, and never again.

    Raises:
        InputError: The model cannot be used, or there is no such force.
    """

    p: MonitorParameters
    outputs = MONITOR.said

    def __init__(self, p: MonitorParameters) -> None:
        self.p = p
        self.force = force_topic(p.force_source)
        self.model = load_model(p.model_file)
        rules = Rules(blocks=round(p.learn / RULES.block), change=p.change, between=p.between)
        self.monitor = monitor(self.model, 1.0 / p.rate, p.timeout, rules, p.floor)
        at_rest = Row(1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        state, _ = compare.step(self.monitor, compare.State(), at_rest)
        compare.step(
            self.monitor, state, at_rest._replace(stamp=2)
        )  # compiled now, not in the loop
        self.inputs = (*USUAL, self.force)
        self.limits = (StampLimits(stale=p.max_age, gap=p.timeout),) * len(self.inputs)
        self.model_id = self.model.digest()

    def start(self) -> State:
        """Before any message."""
        return State(checks=(StampState(),) * len(self.inputs))

    def with_model(self, file: str) -> MonitorCore:
        """The same with another model; raises `ErError` where that cannot be used."""
        return MonitorCore(replace(self.p, model_file=file))

    def taken_over(self, state: State, _before: Core) -> State:
        """The state of a core before as the beginning of this one: the ticks go on, what was learnt is void."""
        return state._replace(mind=compare.State(), rows=())

    def goes_by(self, state: State) -> str:
        """The model."""
        return f"{self.model.name} ({self.p.model_file}) from sample {state.last.seq + 1} on"

    def on_message(
        self, state: State, topic: topics.Topic, message: Any, when: When
    ) -> tuple[State, list[Said]]:
        """Take a part of a tick, if its stamp is good."""
        checks, verdict, (stamp, seq) = judged(self, state.checks, topic, message, when)
        if not verdict.use:
            return state._replace(checks=checks, rows=()), []
        which, part, sensors, stuck = part_of(topic, message, stamp, state.sensors)
        unusable = state.unusable + (stuck or not message.valid)
        gathered, ticks = gather.add(state.gathered, NEEDED, which, stamp, seq, part)
        mind, last, heard, silent = state.mind, state.last, state.heard, state.silent
        rows, said = tuple(map(row_of, ticks)), list[Said]()
        for tick, row in zip(ticks, rows, strict=True):
            mind, answer = compare.step(self.monitor, mind, row)
            last, heard, silent = Tick(tick.stamp, tick.seq), when.steady, False
            said += self._messages(last, answer, mind.watch)
        come = (gathered, checks, sensors, unusable)
        return by_place(State, (*come, mind, rows, last, heard, silent)), said

    def _messages(self, tick: Tick, answer: Answer, seen: Watch) -> list[Said]:
        """Force and error of a tick, each with what it says of the other."""
        status = _STATUS[seen.finding]
        sizes = (seen.error, seen.usual)
        each = zip(self.outputs, answer, sizes, strict=True)
        return [
            (
                topic,
                builders.damper_force(
                    tick,
                    value if math.isfinite(value) else 0.0,
                    force_sd=size,
                    test_ratio=seen.ratio,
                    status=status if math.isfinite(value) else DamperForce.STATUS_LOST,
                    valid=math.isfinite(value),
                ),
            )
            for topic, value, size in each
        ]

    def on_time(self, state: State, when: When) -> tuple[State, list[Said]]:
        """Say once that there is no force any more when the samples stay away."""
        if not state.heard or state.silent:
            return state, []
        if silence(self.p, when.steady - state.heard) <= self.p.timeout:
            return state, []
        nothing = Answer(math.nan, math.nan)
        return state._replace(silent=True), self._messages(state.last, nothing, state.mind.watch)

    def urgent(self, before: State, after: State) -> bool:
        """Whether the model began, or ceased, to explain."""
        return before.mind.watch.finding is not after.mind.watch.finding

    def report(self, state: State) -> Report:
        """Health of the model."""
        if not state.heard:
            return Report("", NodeStatus.STATUS_INITIALIZING, values=self._values(state))
        seen = state.mind.watch
        mode, status, reason = seen.finding.value, _STATUS[seen.finding], self._reason(seen)
        if state.silent:
            mode, status = "silent", NodeStatus.STATUS_LOST
            reason = f"no sample for {self.p.timeout:g} s"
        stamps = counted(state.checks)
        values = self._values(state)
        return Report(mode, status, reason, stamps, state.unusable, not state.silent, values)

    def _reason(self, seen: Watch) -> str:
        """In a sentence, what the error says; without numbers that change all the time."""
        if seen.finding is Finding.FAILS:
            return "the model no longer explains the damper: ~/diagnose says what it lacks"
        if seen.known is not None and (late := self.delay(seen)) > 10.0:
            return f"the error scatters: its growth by {self.p.change:.0%} is found after {late:.0f} s of motion"
        return ""

    def delay(self, seen: Watch) -> float:
        """How long the change that is to be found takes [s]; infinite while the error is learnt."""
        rules = self.monitor.settings.rules
        return seen.known.delay(rules.change, rules.block) if seen.known else math.inf

    def _values(self, state: State) -> dict[str, object]:
        """Figures for diagnostics."""
        seen, rules = state.mind.watch, self.monitor.settings.rules
        values: dict[str, object] = {
            "model": self.model.name,
            "error [N]": f"{seen.error:.4g}",
            "motion judged [s]": f"{seen.moved:.0f}",
            "parts lost": state.gathered.missing,
        }
        if seen.known is not None:
            values |= {
                "error learnt [N]": f"{math.sqrt(float(seen.known.power)):.4g}",
                "error usual in this motion [N]": f"{seen.usual:.4g}",
                "test ratio": f"{seen.ratio:.2f}",
                "between false alarms [h]": f"{rules.between / HOUR:g}",
                f"growth by {rules.change:.0%} is found after [s]": f"{self.delay(seen):.1f}",
            }
        return values


def force_topic(source: str) -> topics.Topic:
    """Topic of a force by its name; raises `InputError` where none can have it."""
    if source == topics.FORCE.name:
        return topics.FORCE
    observer = source.removeprefix(topics.ESTIMATED)
    if observer == source or not observer.isidentifier():
        expected = f"{topics.FORCE.name}, or {topics.ESTIMATED}OBSERVER"
        raise InputError("parameters", "force_source", expected, f"'{source}'")
    return topics.estimated_force(observer)


CORES = {
    MONITOR: Shell(
        MonitorParameters,
        MonitorCore,
        hears=(*USUAL, topics.FORCE),
        says=MONITOR.said,
        period=0.05,
        asked=quality.FOLLOWER,
        around="er_model_lab.nodes.model_monitor",
    )
}
