"""An observer on messages: no node, no clock. Live and in replay the same messages give the same.

The estimate itself is `er_observers.running.runtime`.
"""

from __future__ import annotations

import json
import math
from copy import copy
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

from er_common.common_parameters import silence
from er_common.stamps import Checks, StampLimits, StampState, Verdict, counted
from er_models.errors import InputError
from er_ros_common.builders import Tick
from er_ros_common.core import Core, Said, Shell, When, by_place, judged
from er_ros_common.health import Report
from er_ros_common.stuck import ACCELERATION, DEFLECTION, Watched, check
from std_msgs.msg import String

from er_common import quality, topics
from er_damper_msgs.msg import DamperForce, NodeStatus
from er_observers.feed import Feed, Joined, Motion, feed_of, on_deflection, on_duty, on_motion
from er_observers.held import held
from er_observers.observers.status import LIMITS, Status
from er_observers.programs import OBSERVERS
from er_observers.running import runtime as observer
from er_observers.running.ready import ready
from er_observers.settings import ObserverParameters
from er_ros_common import builders

ON_THE_WIRE = {
    Status.OK: DamperForce.STATUS_OK,
    Status.INITIALISING: DamperForce.STATUS_INITIALIZING,
    Status.DEGRADED: DamperForce.STATUS_DEGRADED,
    Status.WEAK: DamperForce.STATUS_DEGRADED,
    Status.INVALID: DamperForce.STATUS_LOST,
}
GAIN_INFO = topics.Topic(
    "~/gain_info",
    "std_msgs/msg/String",
    "what the gains are and promise, JSON",
    0.0,
    quality.STATUS,
)
INPUTS = (topics.ACCELERATION, topics.DEFLECTION, topics.PWM_APPLIED)
"""What an observer listens to, as it comes within a tick; the deflection only where it is used."""


class State(NamedTuple):
    """What waits for its other half, checks of each input's stamps, the observer's state (None before a sample).

    watched, strut: whether an accelerometer or the deflection sensor is stuck; unusable: samples that were not valid;
    base: stamp of the first sample [ns]; last: the one estimated last, heard: when [ns, steady]; silent, held: whether
    it was said that samples stay away, or that the last estimate is held; driven: stamp of the last sample whose duty
    is known, of the first one before that [ns].
    """

    feed: Feed = Feed()
    checks: Checks = ()
    watched: Watched = Watched()
    strut: Watched = Watched()
    unusable: int = 0
    mind: observer.State | None = None
    base: int = 0
    last: Tick = Tick(0, 0)
    heard: int = 0
    silent: bool = False
    held: bool = False
    driven: int = 0

    @property
    def stamps(self) -> StampState:
        """Counts of all inputs."""
        return counted(self.checks)


class ObserverCore(Core):
    """An observer by the name of its theorem. Files are read when it is made, or tuned to others.

    Raises:
        InputError: Model and gains cannot be used, or not together.
    """

    p: ObserverParameters

    def __init__(self, name: str, p: ObserverParameters) -> None:
        self.topic = topics.estimated_force(name)
        self.name, self.outputs = name, (self.topic,)
        self._load(p)
        self._take(p)

    def _load(self, p: ObserverParameters) -> None:
        """Model and gains, and what is heard with them."""
        model, self.left_out = held(p.model_file, leave_out=p.leave_out)
        gains = ready(p.gains_file, model, self.name)
        self.gains = gains if p.payload else replace(gains, payload=False)
        self.hears_deflection = self.gains.sees_deflection or (
            p.deflection and bool(self.gains.fused.any())
        )
        self.inputs = INPUTS if self.hears_deflection else (INPUTS[0], INPUTS[-1])
        self.optional = () if self.gains.sees_deflection else (topics.DEFLECTION,)
        self.model_id, self.gains_id = model.digest(), self.gains.digest

    def _take(self, p: ObserverParameters) -> None:
        """What silence and age mean."""
        self.p, self.longest = p, round(1e9 * p.timeout)
        self.limits = (StampLimits(stale=p.max_age, gap=p.timeout),) * len(self.inputs)

    def tuned(self, p: ObserverParameters) -> ObserverCore:
        """With another patience, or other files for the same sensors."""
        made = copy(self)
        if files(p) != files(self.p):
            made._load(p)
            if made.gains.sees_deflection != self.gains.sees_deflection:
                expected = "gains for the same sensors while the node is configured"
                raise InputError(p.gains_file, "model.outputs", expected, "others")
            made.hears_deflection, made.inputs = self.hears_deflection, self.inputs
        made._take(p)
        return made

    def taken_over(self, state: State, before: ObserverCore) -> State:
        """The motion and the load that were found before go on with these gains."""
        if state.mind is None or self.gains is before.gains:
            return state
        return state._replace(mind=observer.gone_over(self.gains, state.mind))

    def goes_by(self, state: State) -> str:
        """Model and gains."""
        without = f" without {', '.join(self.left_out)}" if self.left_out else ""
        files = f"{self.gains.model}{without} ({self.p.model_file}), gains {self.p.gains_file}"
        return f"{files}, from sample {state.last.seq + 1} on"

    def start(self) -> State:
        """Before any message."""
        checks = (StampState(),) * len(self.inputs)
        needed = self.gains.sees_deflection
        return State(feed_of(deflection=self.hears_deflection, needed=needed), checks)

    def on_message(
        self, state: State, topic: topics.Topic, message: Any, when: When
    ) -> tuple[State, list[Said]]:
        """Take accelerations, the duty from then on, or the deflection, if the stamp is good."""
        checks, verdict, (stamp, seq) = judged(self, state.checks, topic, message, when)
        back = verdict is Verdict.JUMPED_BACK
        if not verdict.use:
            return state._replace(checks=checks), []
        if topic is topics.PWM_APPLIED:
            duty = message.duty if message.valid else math.nan
            feed, joined = on_duty(state.feed, stamp, duty, back=back)
            if not joined:
                return state._replace(feed=feed, checks=checks), []
            return self._estimated(state, feed, checks, joined, when)
        if topic is topics.DEFLECTION:
            state = state._replace(checks=checks)
            return self._on_deflection(state, stamp, message, when, back=back)
        # values that are not valid are bridged
        read = (message.sprung, message.unsprung)
        watched, stuck = check(state.watched, read, ACCELERATION, stamp)
        good = message.valid and all(map(math.isfinite, read)) and not stuck
        values = read if good else (math.nan, math.nan)
        feed, joined = on_motion(state.feed, Motion(stamp, seq, *values))
        unusable = state.unusable + (not good)
        _, _, _, strut, _, *rest = state
        state = by_place(State, (feed, checks, watched, strut, unusable, *rest))
        return self._estimated(state, feed, checks, joined, when) if joined else (state, [])

    def _on_deflection(
        self, state: State, stamp: int, message: Any, when: When, *, back: bool
    ) -> tuple[State, list[Said]]:
        """Take a deflection; NaN where it is not valid or the sensor is stuck. back: time has jumped back."""
        velocity = message.velocity if message.velocity_valid else math.nan
        strut, stuck = check(state.strut, (message.deflection, velocity), DEFLECTION, stamp)
        good = message.valid and math.isfinite(message.deflection) and not stuck
        value = message.deflection if good else math.nan
        feed, joined = on_deflection(state.feed, stamp, value, back=back)
        state = state._replace(feed=feed, strut=strut, unusable=state.unusable + (not good))
        if not joined:
            return state, []
        return self._estimated(state, feed, state.checks, joined, when)

    def on_time(self, state: State, when: When) -> tuple[State, list[Said]]:
        """Say once that the last estimate is held, and once that it is no longer valid, when the samples stay away."""
        if not state.heard or state.silent:
            return state, []
        since = silence(self.p, when.steady - state.heard)
        if since <= self.p.timeout:
            said = [] if state.held or since <= LIMITS.bridge else self._held(state)
            return state._replace(held=state.held or bool(said)), said
        lost = builders.damper_force(state.last, 0.0, status=DamperForce.STATUS_LOST, valid=False)
        return state._replace(silent=True), [(self.topic, lost)]

    def _held(self, state: State) -> list[Said]:
        """The last estimate once more, degraded."""
        if state.mind is None or state.mind.estimate.status is Status.INVALID:
            return []
        e = state.mind.estimate._replace(status=Status.DEGRADED)
        return [(self.topic, _message(state.last, e))]

    def _estimated(
        self, state: State, feed: Feed, checks: Checks, joined: list[Joined], when: When
    ) -> tuple[State, list[Said]]:
        """Step for each sample that is complete; feed, checks: what waits and is known of stamps now."""
        said: list[Said] = []
        first = joined[0].motion.stamp
        mind, base, driven = state.mind, state.base or first, state.driven or first
        for (stamp, seq, sprung, unsprung), duty, deflection in joined:
            driven = stamp if math.isfinite(duty) else driven
            sample = observer.Sample(1e-9 * (stamp - base), sprung, unsprung, duty, deflection)
            if mind is None:
                mind = observer.start(self.gains, sample)
                estimate = mind.estimate
            elif self.undriven(stamp, driven):
                mind = observer.lose(self.gains, mind, sample.t) if mind.running else mind
                estimate = mind.estimate
            else:
                mind, estimate = observer.step(self.gains, mind, sample)
            last = Tick(stamp, seq)
            said.append((self.topic, _message(last, estimate)))
        silent = held = False  # of a silence that is over nothing has been said
        mine = (mind, base, last, when.steady, silent, held, driven)
        watched = (state.watched, state.strut, state.unusable)
        return by_place(State, (feed, checks, *watched, *mine)), said

    def notes(self) -> list[Said]:
        """What the gains are."""
        g = self.gains
        told = {"observer": g.observer, "gains": g.digest, "model": g.model, **g.figures}
        return [(GAIN_INFO, String(data=json.dumps(told, default=str)))]

    def report(self, state: State) -> Report:
        """Health of the observer."""
        s, mode, status, reason = state, "", NodeStatus.STATUS_INITIALIZING, ""
        values: dict[str, object] = {"duties lost": s.feed.lost}
        if self.hears_deflection:
            values["deflections lost"] = s.feed.blind
        if s.mind is not None:
            mode, estimate = "running", s.mind.estimate
            status, reason = ON_THE_WIRE[estimate.status], estimate.reason
            values |= {"test ratio": f"{estimate.test_ratio:.2f}", "resets": s.mind.resets}
            payload = observer.payload_of(self.gains, s.mind)
            values |= {"payload": payload.text, "sprung mass ratio": f"{payload.ratio:.3f}"}
            if self.hears_deflection:
                values["sprung mass ratio, with deflection"] = f"{s.mind.load:.3f}"
            values["damping asymmetry"] = f"{payload.asymmetry:.3f}"
            if self.undriven(s.last.stamp, s.driven):
                reason = f"{topics.PWM_APPLIED.name}: no usable duty for {self.p.timeout:g} s"
        if s.silent:
            mode, status = "silent", NodeStatus.STATUS_LOST
            reason = f"no sample for {self.p.timeout:g} s"
        valid = mode == "running" and status != NodeStatus.STATUS_LOST
        return Report(mode, status, reason, s.stamps, s.unusable, valid, values)

    def undriven(self, stamp: int, driven: int) -> bool:
        """Whether a duty known last at the stamp `driven` says too little at a later one [ns]."""
        return not 0 <= stamp - driven <= self.longest


def files(p: ObserverParameters) -> tuple[str, str, bool]:
    """What an observer is read from."""
    return p.model_file, p.gains_file, p.leave_out


def _message(tick: Tick, e: observer.Estimate) -> DamperForce:
    """One estimate with the stamp of its sample."""
    return builders.damper_force(
        tick,
        e.force,
        test_ratio=e.test_ratio,
        status=ON_THE_WIRE[e.status],
        valid=e.status is not Status.INVALID,
    )


CORES = {
    program: Shell(
        ObserverParameters,
        partial(ObserverCore, name),
        hears=INPUTS,
        says=(topics.estimated_force(name), GAIN_INFO),
        patience=LIMITS.bridge,
        asked=quality.FOLLOWER,
        around="er_observers.nodes.observer",
    )
    for name, program in OBSERVERS.items()
}
