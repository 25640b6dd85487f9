"""What every observer of the damper force does with a sample: `start`, `step`.

An observer sees two accelerometers, the duty and, where its gains were made for one, a deflection
sensor. Which observer it is lies in its gains (`er_observers.gains`): they hold the law it follows.

``step(gains, state, sample) -> (state, estimate)`` is pure: no clock, no file, no memory but the
state. Nothing in the loop raises; what is wrong shows as a status. One gains object serves one
thread at a time: the compiled part works in its scratch.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from er_models.model import Array

from er_observers.gains import Gains
from er_observers.observers import start_phase
from er_observers.observers import watch as watching
from er_observers.observers.kernel import advance, substeps
from er_observers.observers.status import ROUNDING, Health, Status, judge

BEND = 0.6
"""Share of the parabola through the last three samples that the outputs follow between two.

Whole, it over-bends what moves at a quarter of the sampling rate; from 0.5 to 0.7 the errors on ISO
roads are the smallest, a tenth to a sixth below those of straight lines.
"""


class Sample(NamedTuple):
    """Both accelerations at t [m/s2] and the duty applied from t until the next sample.

    Accelerations are those of the motion, upwards, without gravity. deflection [m]: used by gains
    that were made for such a sensor, and by no others.
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

    t: time of the last sample [s]; z (N,): the observer's own state then; x (n,): the estimate of
    the model's; P (n, n): covariance of x during the start phase, None after it; y (m,): outputs
    then; pace (m,): the rate they came with, NaN where it is not known; change: of the relative
    acceleration since the sample before [m/s2]; duty: in force since t; running: whether a first
    valid sample has come; resets: fresh starts after it; rejected: samples not used or repaired.
    """

    t: float
    z: Array
    x: Array
    P: Array | None
    y: Array
    pace: Array
    change: float
    duty: float
    health: Health
    estimate: Estimate
    running: bool
    resets: int
    rejected: int


def start(gains: Gains, sample: Sample, x: Array | None = None) -> State:
    """State at the first sample: the likeliest for its accelerations, or x (n,) where known.

    A sample that is not valid leaves the observer waiting for one that is.
    """
    duty, _ = _duty(gains, sample.duty, 0.0)
    health = watching.begin(gains.watch)
    law, running = gains.claim.solution.law, _valid(gains, sample)
    y = _outputs(gains, sample) if running else np.zeros(law.S.shape[1])
    if not running:
        health = health._replace(lost=math.inf)
    first, P = _likeliest(gains, y, duty) if x is None else np.array(x, float), None
    if running and gains.opening is not None:
        prior = gains.opening.prior
        first, P = start_phase.follow(gains.opening, first, prior, duty, 0.0, y)
    z = law.state(first, y, np.zeros(law.order))
    estimate = _estimate(gains, first, health)
    rejected = 0 if running else 1
    return State(
        sample.t, z, first, P, y, y + math.nan, 0.0, duty, health, estimate, running, 0, rejected
    )


def step(gains: Gains, state: State, sample: Sample) -> tuple[State, Estimate]:
    """Estimate at the time of this sample; until then the duty of the state was in force.

    Samples that are late or double change nothing. A jump of time by more than the hold limit, or
    valid data after so long without, starts afresh.
    """
    hold = gains.limits.hold + ROUNDING
    dt = sample.t - state.t
    if not state.running and math.isfinite(sample.t):
        state = _restart(gains, state, sample)
    elif not math.isfinite(dt) or -hold < dt <= 0.0:
        state = state._replace(rejected=state.rejected + 1)
    elif abs(dt) > hold:
        state = _restart(gains, state, sample)
    elif not _valid(gains, sample):
        state = _bridge(gains, state, sample, dt)
    elif state.health.lost + dt > hold:
        state = _restart(gains, state, sample)
    else:
        state = _follow(gains, state, sample, dt)
    return state, state.estimate


def _follow(gains: Gains, state: State, sample: Sample, dt: float) -> State:
    """Advance with the measurement."""
    y, last = _outputs(gains, sample), state.duty
    z, x, P, end = _advanced(gains, state, y, dt)
    duty, repaired = _duty(gains, sample.duty, last)
    before = float(state.y[0] - state.y[1])
    change = sample.sprung_acceleration - sample.unsprung_acceleration - before
    facts = watching.Facts(
        rate=watching.decay_rate(gains.watch, last, 1.0 - math.tanh(end) ** 2),
        correction=float(x[1] - state.x[1]) - dt * (before + 0.5 * change),
        bend=change - state.change,
        repaired=repaired,
    )
    health = watching.follow(gains.watch, gains.limits, state.health, dt, facts)
    if state.P is not None:
        health = health._replace(doubt=0.0 if P is None else 1.0)
    return state._replace(
        t=sample.t,
        z=z,
        x=x,
        P=P,
        y=y,
        pace=(y - state.y) / dt,
        change=change,
        duty=duty,
        health=health,
        estimate=_estimate(gains, x, health),
        rejected=state.rejected + repaired,
    )


def _advanced(
    gains: Gains, state: State, y: Array, dt: float
) -> tuple[Array, Array, Array | None, float]:
    """z, x, P and the gate's input dt [s] later: by the proved gain, or in the start phase."""
    law = gains.claim.solution.law
    if state.P is None or gains.opening is None:
        z = np.empty_like(state.z)
        bend = _bend(state, y, dt)
        end = advance(*gains.plan, state.z, state.y, y, bend, state.duty, dt, substeps(dt), z)
        return z, law.R @ z + law.S @ y, None, end
    x, P = start_phase.follow(gains.opening, state.x, state.P, state.duty, dt, y)
    done = start_phase.finished(gains.opening, P)
    return law.state(x, y, state.z), x, None if done else P, float(gains.form.Gamma @ x)


def _bend(state: State, y: Array, dt: float) -> Array:
    """Bend (m,) of the outputs over the last dt [s], from the change of their rate; none after a gap.

    The whole change would be that of a parabola through three samples.
    """
    change = (y - state.y) / dt - state.pace
    return np.nan_to_num(0.5 * BEND * dt * change, copy=False, nan=0.0)


def _bridge(gains: Gains, state: State, sample: Sample, dt: float) -> State:
    """Advance without a measurement, on the model alone."""
    x, P, nothing = np.empty_like(state.x), state.P, np.zeros_like(state.y)
    if P is None or gains.opening is None:
        n_sub = substeps(dt)
        advance(*gains.bridge, state.x, nothing, nothing, nothing, state.duty, dt, n_sub, x)
    else:
        x, P = start_phase.follow(gains.opening, state.x, P, state.duty, dt, nothing + math.nan)
    y = gains.form.C @ x
    health = watching.missed(gains.limits, state.health, dt)
    return state._replace(
        t=sample.t,
        z=gains.claim.solution.law.state(x, y, state.z),
        x=x,
        P=P,
        y=y,
        pace=y + math.nan,
        change=0.0,
        duty=_duty(gains, sample.duty, state.duty)[0],
        health=health,
        estimate=_estimate(gains, x, health),
        rejected=state.rejected + 1,
    )


def _restart(gains: Gains, state: State, sample: Sample) -> State:
    """Start afresh, counting it."""
    fresh = start(gains, sample)
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
    """Duty within the gains' range, and whether it was repaired; NaN keeps the one before."""
    low, high = gains.claim.spec.rho
    if not math.isfinite(duty):
        return before, True
    return min(max(duty, low), high), not low - 1e-6 <= duty <= high + 1e-6


def _likeliest(gains: Gains, y: Array, duty: float) -> Array:
    """State of largest likelihood that makes the accelerations y, typical sizes as spread."""
    form = gains.form
    at = int(np.argmax(np.abs(form.B)))
    spread = gains.claim.scaling.state**2
    spread[at] = (0.5 * duty * form.B[at] / form.A[at, at]) ** 2
    weighted = spread[:, None] * form.C.T
    return np.asarray(weighted @ np.linalg.solve(form.C @ weighted, y))


def _estimate(gains: Gains, x: Array, health: Health) -> Estimate:
    """What the state says; zeros when it is invalid."""
    status, reason = judge(gains.limits, health)
    if status is Status.INVALID:
        return Estimate(0.0, 0.0, 0.0, status, 0.0, reason)
    ratio = watching.contradiction(health.power, health.floor)
    return Estimate(float(gains.form.F @ x), float(x[0]), float(x[1]), status, ratio, reason)
