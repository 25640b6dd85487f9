"""The fault estimator on messages: no node, no clock. Live and in replay the same messages give the same.

The estimate itself is `er_observers.faults.estimator`.
"""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from typing import Any, NamedTuple

from er_common.common_parameters import silence
from er_common.gather import Gathered
from er_common.stamps import Checks, StampLimits, StampState, counted
from er_models.errors import InputError
from er_models.files import load_model
from er_models.model import Model
from er_models.nearest import nearest
from er_models.static_damper import static_damper
from er_ros_common.builders import Tick
from er_ros_common.core import Core, Said, Shell, When, by_place, judged
from er_ros_common.health import Report
from er_ros_common.parts import part_of
from er_ros_common.stuck import Watched

from er_common import gather, quality, topics
from er_damper_msgs.msg import FaultEstimate, NodeStatus
from er_observers.fault_settings import MEASURED, NONE, FaultParameters
from er_observers.faults import estimator
from er_observers.faults.ready import ready
from er_observers.faults.rules import RULES
from er_observers.faults.sample import NOTHING, Estimate, Status, sample_of
from er_observers.programs import FAULT_ESTIMATOR, OBSERVERS
from er_ros_common import builders

ON_THE_WIRE = {
    Status.OK: FaultEstimate.STATUS_OK,
    Status.INITIALISING: FaultEstimate.STATUS_INITIALIZING,
    Status.DEGRADED: FaultEstimate.STATUS_DEGRADED,
    Status.UNEXPLAINED: FaultEstimate.STATUS_DEGRADED,
    Status.INVALID: FaultEstimate.STATUS_LOST,
}
_FORCES = {topic.name: topic for topic in map(topics.estimated_force, OBSERVERS)}
USUAL = (topics.ACCELERATION, topics.DEFLECTION, topics.PWM_APPLIED)


class State(NamedTuple):
    """Ticks that wait for a part, checks of each input's stamps, the estimator's state (None before a sample).

    body, strut: whether a sensor is stuck; unusable: messages that were not valid or stuck; base: stamp of the first
    sample [ns]; last: the one estimated last, heard: when [ns, steady]; silent: whether it was said that samples stay
    away.
    """

    gathered: Gathered = Gathered()
    checks: Checks = ()
    body: Watched = Watched()
    strut: Watched = Watched()
    unusable: int = 0
    mind: estimator.State | None = None
    base: int = 0
    last: Tick = Tick(0, 0)
    heard: int = 0
    silent: bool = False

    @property
    def stamps(self) -> StampState:
        """Counts of all inputs."""
        return counted(self.checks)


class FaultCore(Core):
    """The model file is read when it is made, or tuned to another one.

    Raises:
        InputError: The model cannot be used.
    """

    p: FaultParameters
    outputs = (topics.FAULT,)

    def __init__(self, p: FaultParameters) -> None:
        self._load(p)
        self.force = _topic(p.force_source)
        given = () if self.force is None else (self.force,)
        self.inputs = (*USUAL, *given)
        self.needed = tuple(range(len(self.inputs)))
        self._take(p)

    def _load(self, p: FaultParameters) -> None:
        """The estimator of the model file."""
        model, left_out = load_model(p.model_file), tuple[str, ...]()
        if p.leave_out:
            model, left_out = nearest(model, static_damper)
        self.left_out = left_out
        rules = replace(RULES, tolerance=p.tolerance, smallest=p.smallest_loss, hold=p.timeout)
        self.estimator = ready(model, rules, force_noise(p, model), 1.0 / p.rate)
        self.model, self.model_id = model.name, model.digest()

    def _take(self, p: FaultParameters) -> None:
        """What silence and age mean."""
        self.p = p
        self.limits = (StampLimits(stale=p.max_age, gap=p.timeout),) * len(self.inputs)
        rules = replace(self.estimator.rules, hold=p.timeout)
        self.estimator = replace(self.estimator, rules=rules)

    def tuned(self, p: FaultParameters) -> FaultCore:
        """With another patience, or another model."""
        made = copy(self)
        if (p.model_file, p.leave_out) != (self.p.model_file, self.p.leave_out):
            made._load(p)
        made._take(p)
        return made

    def taken_over(self, state: State, before: FaultCore) -> State:
        """What was learnt is of the model before: with another one the estimate begins anew."""
        return state if self.model_id == before.model_id else state._replace(mind=None)

    def goes_by(self, state: State) -> str:
        """The model."""
        without = f" without {', '.join(self.left_out)}" if self.left_out else ""
        return f"{self.model}{without} ({self.p.model_file}), from sample {state.last.seq + 1} on"

    def start(self) -> State:
        """Before any message."""
        return State(checks=(StampState(),) * len(self.inputs))

    def on_message(
        self, state: State, topic: topics.Topic, message: Any, when: When
    ) -> tuple[State, list[Said]]:
        """Take a part of a tick, if its stamp is good."""
        checks, verdict, (stamp, seq) = judged(self, state.checks, topic, message, when)
        if not verdict.use:
            return state._replace(checks=checks), []
        which, part, (body, strut), stuck = part_of(
            topic, message, stamp, (state.body, state.strut)
        )
        unusable = state.unusable + (stuck or not message.valid)
        gathered, ticks = gather.add(state.gathered, self.needed, which, stamp, seq, part)
        said: list[Said] = []
        mind, base, last = state.mind, state.base, state.last
        heard, silent = state.heard, state.silent
        if ticks:
            base = base or ticks[0].stamp
            mind, last, said = self._estimated(mind, base, ticks)
            # samples come again: the next silence is to be said anew
            heard, silent = when.steady, False
        come = (gathered, checks, body, strut, unusable)
        return by_place(State, (*come, mind, base, last, heard, silent)), said

    def on_time(self, state: State, when: When) -> tuple[State, list[Said]]:
        """Say once that the estimate is no longer valid when the samples stay away."""
        if not state.heard or state.silent:
            return state, []
        if silence(self.p, when.steady - state.heard) <= self.p.timeout:
            return state, []
        nothing = NOTHING._replace(status=Status.INVALID)
        return state._replace(silent=True), [(topics.FAULT, _message(state.last, nothing))]

    def _estimated(
        self, mind: estimator.State | None, base: int, ticks: list[gather.Tick]
    ) -> tuple[estimator.State | None, Tick, list[Said]]:
        """Step for each tick that can go on, at least one; base: stamp of the first of all [ns]."""
        said: list[Said] = []
        for tick in ticks:
            sample = sample_of(tick, base)
            if mind is None:
                mind = estimator.start(self.estimator, sample)
                estimate = mind.estimate
            else:
                mind, estimate = estimator.step(self.estimator, mind, sample)
            last = Tick(tick.stamp, tick.seq)
            said.append((topics.FAULT, _message(last, estimate)))
        return mind, last, said

    def report(self, state: State) -> Report:
        """Health of the estimator."""
        s, mode, status, reason = state, "", NodeStatus.STATUS_INITIALIZING, ""
        values: dict[str, object] = {"parts lost": s.gathered.missing}
        if s.mind is not None:
            mode, e = "running", s.mind.estimate
            status, reason = ON_THE_WIRE[e.status], e.reason
            values |= {"fault": e.kind.name.lower(), "certainty": f"{e.certainty:.3f}"}
            values |= {"test ratio": f"{e.test_ratio:.2f}", "resets": s.mind.resets}
        if s.silent:
            mode, status = "silent", NodeStatus.STATUS_LOST
            reason = f"no sample for {self.p.timeout:g} s"
        valid = mode == "running" and status != NodeStatus.STATUS_LOST
        return Report(mode, status, reason, s.stamps, s.unusable, valid, values)


def force_noise(p: FaultParameters, model: Model) -> float | None:
    """Deviation of the force that is given [N]; None where none is.

    Raises `InputError` for an observer's force of unknown deviation: it depends on gains and road.
    """
    if p.force_source == NONE:
        return None
    if p.force_noise > 0.0:
        return p.force_noise
    if p.force_source != MEASURED:
        raise InputError(
            "parameters", "force_noise", f"the deviation of {p.force_source} [N]", "0"
        )
    return float(model.rig.get("force_noise", 7e-3 * model.scales.force))


def _topic(source: str) -> topics.Topic | None:
    """Topic of the force to go by."""
    if source == NONE:
        return None
    return topics.FORCE if source == MEASURED else _FORCES[source]


def _message(tick: Tick, e: Estimate) -> FaultEstimate:
    """One estimate with the stamp of its tick."""
    return builders.fault_estimate(
        tick,
        e.factors,
        e.deviations,
        [int(state) for state in e.states],
        kind=max(int(e.kind) + 1, FaultEstimate.KIND_UNKNOWN),
        certainty=e.certainty,
        residual=e.residual,
        test_ratio=e.test_ratio,
        unexplained=e.unexplained,
        status=ON_THE_WIRE[e.status],
        valid=e.status not in (Status.INVALID, Status.INITIALISING),
    )


CORES = {
    FAULT_ESTIMATOR: Shell(
        FaultParameters,
        FaultCore,
        hears=(*USUAL, topics.FORCE),
        says=FaultCore.outputs,
        period=0.05,
        asked=quality.FOLLOWER,
        whole=(topics.DEFLECTION,),
    )
}
