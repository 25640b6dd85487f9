"""What every observer of the damper force does with a sample: `start`, `step`.

An observer sees two accelerometers, the duty and, where its gains were made for one, a deflection
sensor. Which observer it is lies in its gains (`er_observers.gains`): they hold the law it follows.

``step(gains, state, sample) -> (state, estimate)`` is pure: no clock, no file, no memory but the
state. Nothing in the loop raises; what is wrong shows as a status. One gains object serves one
thread at a time: the compiled part works in its scratch.
"""

from __future__ import annotations

import math
from typing import NamedTuple, cast

import numpy as np
from er_models.model import Array

from er_observers.gains import Gains
from er_observers.observers import fusion, payload
from er_observers.observers import watch as watching
from er_observers.observers.fusion import fuse
from er_observers.observers.kernel import advance, substeps
from er_observers.observers.payload import Payload
from er_observers.observers.sample import (
    CHANGE,
    HEALTH,
    Layout,
    better,
    duty_within,
    keep,
    run_sample,
)
from er_observers.observers.sample import said as said_of
from er_observers.observers.status import ROUNDING, VERDICTS, Health, Status
from er_observers.opening import phase as start_phase
from er_observers.opening.phase import Opening

_NEW = tuple.__new__
"""Makes a named tuple in half the time that its own call takes."""
Said = tuple[float, float, float, float, int]


class Sample(NamedTuple):
    """Both accelerations at t [m/s2] and the duty applied from t until the next sample.

    Accelerations are those of the motion, upwards, without gravity. deflection [m]: fused with them
    where it is a number (`observers.fusion`); gains that were made for such a sensor need it.
    """

    t: float
    sprung_acceleration: float
    unsprung_acceleration: float
    duty: float
    deflection: float = math.nan


class Estimate(NamedTuple):
    """Damper force [N], deflection [m] and its velocity [m/s] at the sample's time, with health.

    test_ratio: above one the accelerations contradict the model. An INVALID estimate holds zeros,
    never NaN; a WEAK one is the model's, and a wrong deflection would not be noticed.
    """

    force: float
    deflection: float
    deflection_velocity: float
    status: Status
    test_ratio: float
    reason: str


class State(NamedTuple):
    """Memory between samples.

    t: time of the last sample [s]; memory: what the compiled part keeps, see `sample`; layout: where
    things lie in it; P (n, n): covariance of x during the start phase, None after it; duty: in force
    since t; running: whether a first valid sample has come; resets: fresh starts after it; rejected:
    samples not used or repaired.
    """

    t: float
    memory: Array
    layout: Layout
    P: Array | None
    duty: float
    estimate: Estimate
    running: bool
    resets: int
    rejected: int

    @property
    def x(self) -> Array:
        """Estimate of the model's state (n,)."""
        return self.memory[self.layout.x]

    @property
    def z(self) -> Array:
        """The observer's own state (N,)."""
        return self.memory[self.layout.z]

    @property
    def y(self) -> Array:
        """Outputs of the last sample (m,), or what the model gave in their place."""
        return self.memory[self.layout.y]

    @property
    def load(self) -> float:
        """Sprung mass over the believed one that the deflection sensor's force is told with; 1 before any is found."""
        return self.memory.item(self.layout.fusion_at + fusion.THETA)

    @property
    def health(self) -> Health:
        """Memory of the watch."""
        doubt, decay, lost, healing, power, floor, weak, contradicted = self.memory[
            HEALTH
        ].tolist()
        return Health(doubt, decay, lost, healing, power, floor, weak > 0.0, contradicted > 0.0)


def start(
    gains: Gains,
    sample: Sample,
    x: Array | None = None,
    known: Array | None = None,
    fused: Array | None = None,
) -> State:
    """State at the first sample: the likeliest for its accelerations, or x (n,) where known.

    known, fused: what was learnt of the sprung mass before (`payload`, `fusion`). A sample that is not valid leaves the
    observer waiting for one that is. `InputError` for an x beyond what the model's envelope allows.
    """
    if x is not None and gains.spread is not None:
        start_phase.check_start(gains.form.states, gains.spread, x)
    duty, _ = _duty(gains, sample.duty, 0.0)
    law, running = gains.claim.solution.law, _valid(gains, sample)
    known = payload.begin() if known is None else payload.interrupted(known)
    y = _outputs(gains, sample) if running else np.zeros(law.S.shape[1])
    seen = payload.seen(known, y)
    P = None
    if x is not None:
        first = np.array(x, float)
    else:  # the start phase weighs the sample itself, against a car at rest
        first = _likeliest(gains, seen, duty) if gains.opening is None else np.zeros(gains.form.n)
    if running and gains.opening is not None:
        prior = gains.opening.prior
        first, P = start_phase.follow(gains.opening, first, prior, duty, 0.0, seen)
    z = law.state(first, seen, np.zeros(law.order))
    fused = fusion.begin() if fused is None else fusion.interrupted(fused)
    memory = np.concatenate(
        [watching.begin(gains.rules), [0.0], y, y + math.nan, first, z, known, fused]
    )
    if not running:
        memory[watching.LOST] = math.inf
    said = _said(gains, memory)
    if running:  # a deflection sensor that nobody asked is not refused
        said = _fused(gains, sample, duty, 0.0, memory, said)
    estimate = _says(*said)
    rejected = 0 if running else 1
    return State(sample.t, memory, gains.layout, P, duty, estimate, running, 0, rejected)


def step(gains: Gains, state: State, sample: Sample) -> tuple[State, Estimate]:
    """Estimate at the time of this sample; until then the duty of the state was in force.

    Samples that are late or double change nothing. A jump of time by more than the hold limit, or
    valid data after so long without, starts afresh.
    """
    if state.running and state.P is None:
        t, sprung, unsprung, asked, deflection = sample
        memory = state.memory.copy()
        force, x, v, ratio, verdict, duty, repaired, goes_on = run_sample(
            gains.book, memory, sprung, unsprung, deflection, state.duty, asked, t - state.t
        )
        if goes_on:
            told, rejected = _says(force, x, v, ratio, verdict), state.rejected + repaired
            parts = (t, memory, state.layout, None, duty, told, True, state.resets, rejected)
            return _NEW(State, parts), told
    state = _other(gains, state, sample)
    return state, state.estimate


def lose(gains: Gains, state: State, t: float) -> State:
    """The state where nothing is known of the motion any more at time t [s]: not valid; the next sample starts afresh.

    What was learnt of the sprung mass stays.
    """
    return _restart(gains, state, Sample(t, math.nan, math.nan, math.nan))


def gone_over(gains: Gains, state: State) -> State:
    """The state at the same instant with other gains, perhaps of another model, for the same sensors.

    The estimate x of the motion stays, and what was learnt of the sprung mass; a filter with a deflection sensor, whose
    lacking force is that of the model before, begins anew.
    """
    old, kept = state.layout, state.memory
    known = payload.interrupted(kept[old.payload])
    law = gains.claim.solution.law
    z = law.state(state.x, payload.seen(known, state.y), np.zeros(law.order))
    fused = fusion.interrupted(kept[old.fusion])
    memory = np.concatenate([kept[: old.z_at], z, known, fused])
    return state._replace(memory=memory, layout=gains.layout)


def payload_of(gains: Gains, state: State) -> Payload:
    """What is known of the sprung mass."""
    return payload.said(gains.mass, state.memory[state.layout.payload])


def _other(gains: Gains, state: State, sample: Sample) -> State:
    """The state after a sample of the start phase, or one that does not simply follow the one before."""
    hold = gains.limits.hold + ROUNDING
    dt = sample.t - state.t
    if not state.running and math.isfinite(sample.t):
        return _restart(gains, state, sample)
    if not math.isfinite(dt) or -hold < dt <= 0.0:
        return state._replace(rejected=state.rejected + 1)
    if abs(dt) > hold:
        return _restart(gains, state, sample, other=dt < 0.0)
    if not _valid(gains, sample):
        return _bridge(gains, state, sample, dt)
    if state.memory.item(watching.LOST) + dt > hold:
        return _restart(gains, state, sample)
    return _find(gains, state, sample, dt)


def _find(gains: Gains, state: State, sample: Sample, dt: float) -> State:
    """Advance with the measurement in the start phase."""
    memory = np.empty_like(state.memory)
    P, said, duty, repaired = _found(gains, state, sample, dt, memory)
    return state._replace(
        t=sample.t,
        memory=memory,
        P=P,
        duty=duty,
        estimate=_says(*said),
        running=True,
        rejected=state.rejected + repaired,
    )


def _found(
    gains: Gains, state: State, sample: Sample, dt: float, memory: Array
) -> tuple[Array | None, Said, float, bool]:
    """Covariance, what is said and the duty in the start phase, whose last sample ends the doubt."""
    opening, lay, y = cast(Opening, gains.opening), state.layout, _outputs(gains, sample)
    duty, repaired = _duty(gains, sample.duty, state.duty)
    known = payload.interrupted(state.memory[lay.payload])
    seen = payload.seen(known, y)
    x, P = start_phase.follow(opening, state.x, cast(Array, state.P), state.duty, dt, seen)
    z = gains.claim.solution.law.state(x, seen, state.z)
    memory[lay.y], memory[lay.x], memory[lay.z], memory[lay.payload] = y, x, z, known
    end, rest = float(gains.form.Gamma @ x), (lay, memory)
    keep(gains.reading, gains.rules, state.memory, state.duty, dt, repaired, end, *rest)
    done = start_phase.finished(opening, P)
    memory[watching.DOUBT] = 0.0 if done else 1.0
    memory[lay.fusion] = state.memory[lay.fusion]
    said = _fused(gains, sample, state.duty, dt, memory, _said(gains, memory))
    return None if done else P, said, duty, repaired


def _fused(
    gains: Gains, sample: Sample, duty: float, dt: float, memory: Array, said: Said
) -> Said:
    """What is said with a deflection sensor, its memory brought on, in place; duty: in force for dt [s] until now."""
    fused, x, y = memory[gains.layout.fusion], memory[gains.layout.x], memory[gains.layout.y]
    deflection = (
        sample.deflection if abs(sample.deflection) <= gains.limits.deflection else math.nan
    )
    return better(said, fuse(gains.fused, fused, y[0], y[1], deflection, x, duty, dt), fused)


def _bridge(gains: Gains, state: State, sample: Sample, dt: float) -> State:
    """Advance without a measurement, on the model alone."""
    lay, P = state.layout, state.P
    x, nothing = np.empty(lay.n), np.zeros(lay.m)
    if P is None or gains.opening is None:
        n_sub = substeps(dt)
        advance(*gains.bridge, state.x, nothing, nothing, nothing, state.duty, dt, n_sub, x, 0.0)
    else:
        x, P = start_phase.follow(gains.opening, state.x, P, state.duty, dt, nothing + math.nan)
    seen = gains.form.C @ x
    memory = state.memory.copy()
    known = payload.interrupted(memory[lay.payload])
    watching.missed(gains.rules, memory[HEALTH], dt)
    memory[CHANGE] = 0.0
    memory[lay.y], memory[lay.pace], memory[lay.x] = payload.told(known, seen), math.nan, x
    memory[lay.z], memory[lay.payload] = gains.claim.solution.law.state(x, seen, state.z), known
    memory[lay.fusion] = fusion.interrupted(memory[lay.fusion])
    return state._replace(
        t=sample.t,
        memory=memory,
        P=P,
        duty=_duty(gains, sample.duty, state.duty)[0],
        estimate=_estimate(gains, memory),
        rejected=state.rejected + 1,
    )


def _restart(gains: Gains, state: State, sample: Sample, *, other: bool = False) -> State:
    """Start afresh, counting it; other: time went back, so that what was learnt may belong to another drive."""
    lay = state.layout
    learnt = (None, None) if other else (state.memory[lay.payload], state.memory[lay.fusion])
    fresh = start(gains, sample, None, *learnt)
    return fresh._replace(
        resets=state.resets + state.running, rejected=state.rejected + fresh.rejected
    )


def _valid(gains: Gains, sample: Sample) -> bool:
    """Whether the outputs are numbers within belief; comparisons with NaN are false."""
    sprung, unsprung = gains.limits.acceleration
    return (
        abs(sample.sprung_acceleration) <= sprung
        and abs(sample.unsprung_acceleration) <= unsprung
        and (not gains.sees_deflection or abs(sample.deflection) <= gains.limits.deflection)
        and math.isfinite(sample.t)
    )


def _outputs(gains: Gains, sample: Sample) -> Array:
    """Measured outputs (m,) of a valid sample."""
    if gains.sees_deflection:
        return np.array([*sample[1:3], sample.deflection])
    return np.array(sample[1:3])


def _duty(gains: Gains, duty: float, before: float) -> tuple[float, bool]:
    """Duty within the gains' range, and whether it was repaired."""
    return duty_within(duty, before, *gains.claim.spec.rho)


def _likeliest(gains: Gains, y: Array, duty: float) -> Array:
    """State of largest likelihood that makes the accelerations y, typical sizes as spread."""
    form = gains.form
    at = int(np.argmax(np.abs(form.B)))
    spread = gains.claim.scaling.state**2
    spread[at] = (0.5 * duty * form.B[at] / form.A[at, at]) ** 2
    weighted = spread[:, None] * form.C.T
    return np.asarray(weighted @ np.linalg.solve(form.C @ weighted, y))


def _estimate(gains: Gains, memory: Array) -> Estimate:
    """What the memory says."""
    return _says(*_said(gains, memory))


def _said(gains: Gains, memory: Array) -> Said:
    """What the memory says of the accelerometers alone."""
    return said_of(gains.reading, gains.rules, gains.layout, memory)


def _says(
    force: float, deflection: float, velocity: float, ratio: float, verdict: int
) -> Estimate:
    """The estimate; zeros when it is invalid."""
    status, reason = VERDICTS[verdict]
    if status is Status.INVALID:
        return Estimate(0.0, 0.0, 0.0, status, 0.0, reason)
    return _NEW(Estimate, (force, deflection, velocity, status, ratio, reason))
