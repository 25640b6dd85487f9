"""Kalman filters of the damper force behind the protocol of the observers: `make`, `start`, `step`.

They know what the scenarios share: the noise of the accelerometers (0.025 m/s2, also where a scenario
has none), how rough the road is, how wrong the start may be. Nothing else is assumed wrong with the
model, as is usual; what more process noise or a blunter sensor would change is in
docs/results/observer_comparison.md.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from er_models.constants import SAMPLE_TIME
from er_models.linear import LinearForm, relative_form
from er_models.model import Array, Model
from er_observers.filters.extended import extended_sample
from er_observers.filters.flow import noise_covariance, substep_matrices
from er_observers.filters.unscented import unscented_sample
from er_observers.observers.status import Status
from er_observers.running.runtime import Estimate, Sample
from er_observers.scaling import road_density

from er_studies.observers.scenarios.starts import SPREAD


class Kind(NamedTuple):
    """A filter: title, what it does with a sample, substeps of a sample, and its share of the road's density.

    Two substeps make the extended filter cheaper and better than more: its Jacobian then sees the
    gate as wide as a step is long. The share is what the ISO roads of the scenarios have: their tyre
    deflection changes by 0.043 m/s in rms from sample to sample.
    """

    title: str
    sample: Callable[..., None]
    n_sub: int
    share: float


KINDS = {
    "ekf": Kind("extended Kalman filter", extended_sample, 2, share=0.35),
    "ukf": Kind("unscented Kalman filter", unscented_sample, 4, share=0.35),
}


@dataclass(frozen=True, eq=False)
class Statement:
    """What a filter is told, by default the same for every scenario.

    noise: standard deviation of both accelerometers [m/s2], that of the scenarios with noise; spread
    (n,): standard deviations of the error of the start [SI]; period: sample time [s].
    """

    noise: float = 0.025
    spread: tuple[float, ...] = SPREAD
    period: float = SAMPLE_TIME


@dataclass(frozen=True, eq=False)
class Filter:
    """A filter made for one model.

    linear (n, n), kick (n,), noise (n, n): of one substep of `h` [s]; variance (2,): of the
    outputs; first (n, n): covariance of the start; force (n,): what each state adds to it.
    """

    kind: Kind
    form: LinearForm
    h: float
    linear: Array
    kick: Array
    noise: Array
    C: Array
    variance: Array
    first: Array
    force: tuple[float, ...]


class State(NamedTuple):
    """Time of the last sample [s], state x (n,), covariance P (n, n), duty in force, estimate."""

    t: float
    x: Array
    P: Array
    duty: float
    estimate: Estimate


def make(
    name: str, model: Model, statement: Statement | None = None, kind: Kind | None = None
) -> Filter:
    """The filter `name` of `KINDS`, or another kind, for a vehicle model, compiled; raises as `relative_form`."""
    known, form = statement or Statement(), relative_form(model)
    kind = kind or KINDS[name]
    h = known.period / kind.n_sub
    linear, kick = substep_matrices(form, h)
    density = kind.share * road_density(model) * form.D1**2
    made = Filter(
        kind, form, h, linear, kick, noise_covariance(form, density, h),
        C=np.ascontiguousarray(form.C),
        variance=np.full(form.C.shape[0], known.noise**2),
        first=np.diag(np.square(known.spread)),
        force=tuple(form.F.tolist()),
    )  # fmt: skip
    rest = Sample(0.0, 0.0, 0.0, 0.0)
    step(made, start(made, rest), rest._replace(t=known.period))
    return made


def start(p: Filter, sample: Sample, x: Array | None = None) -> State:
    """State at the first sample: x (n,) or rest, corrected by the accelerations of the sample."""
    first = np.zeros(p.form.n) if x is None else np.array(x, float)
    P = p.first.copy()
    _advance(p, 0, sample, sample.duty, first, P)
    return State(sample.t, first, P, sample.duty, _estimate(p, first))


def step(p: Filter, state: State, sample: Sample) -> tuple[State, Estimate]:
    """Estimate at the time of this sample; until then the duty of the state was in force.

    Accelerations that are no numbers are predicted over; late samples change nothing.
    """
    steps = round((sample.t - state.t) / p.h) if math.isfinite(sample.t) else 0
    if steps <= 0:
        return state, state.estimate
    x, P = state.x.copy(), state.P.copy()
    _advance(p, steps, sample, state.duty, x, P)
    duty = min(max(sample.duty, 0.0), 1.0) if math.isfinite(sample.duty) else state.duty
    estimate = _estimate(p, x)
    return State(sample.t, x, P, duty, estimate), estimate


def _advance(p: Filter, steps: int, sample: Sample, duty: float, x: Array, P: Array) -> None:
    """Predict over the substeps and correct, x and P in place."""
    y = np.array([sample.sprung_acceleration, sample.unsprung_acceleration])
    p.kind.sample(p.linear, p.kick, p.form.Gamma, p.noise, p.C, p.variance, duty, steps, y, x, P)


def _estimate(p: Filter, x: Array) -> Estimate:
    """What the state says; a filter that has left all bounds is invalid."""
    values = x.tolist()
    force = sum(map(operator.mul, p.force, values))
    if not math.isfinite(force):
        return Estimate(0.0, 0.0, 0.0, Status.INVALID, 0.0, "the filter has diverged")
    return Estimate(force, values[0], values[1], Status.OK, 0.0, "")
