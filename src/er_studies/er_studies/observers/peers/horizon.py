r"""Moving-horizon estimation: the start of the last samples that explains accelerations and deflection best.

Over N samples the state (x, v, f) at their begin is sought that minimises

.. math::  \left\| \frac{x_0 - \hat x_0}{\sigma_0} \right\|^2 + \sum_k \left(\frac{x_k - x_{m,k}}{\sigma_x}\right)^2
           + \left(\frac{m_s y_{1,k} + (k_s + k_0) x_k + c_0 v_k + f_k}{m_s \sigma_a}\right)^2

with the relative acceleration as input and the gate's mean along straight lines, by Gauss and Newton from the estimate
of the sample before, derivatives by differences; x^_0 is what that horizon says of this one's begin.

Source: Rao, Rawlings and Mayne 2003.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from er_models.linear import relative_form
from er_models.model import Array, Model
from er_observers.filters.horizon import along, solved
from er_observers.observers.status import Status
from er_observers.running.runtime import Estimate, Sample

TUNED = {"samples": (3.0, 30.0), "arrival": (0.1, 100.0), "sharp": (0.3, 30.0)}
"""What is tuned, with bounds: N; deviation of the start in multiples of (sigma_x, 10 mm/s, 1 N); the balance's
deviation in multiples of its noise."""


class Horizon(NamedTuple):
    """numbers: m_s, k_s, k_0, c_0, f_c, 1/tau, k_1, c_1, sigma_a, sigma_x, arrival, sharp; samples: N."""

    numbers: Array
    samples: int


class State(NamedTuple):
    """rows (up to N, 5): time, relative and sprung acceleration, deflection, duty; first (3,): start of the horizon."""

    rows: Array
    first: Array
    estimate: Estimate


def make(model: Model, samples: float, arrival: float, sharp: float) -> Horizon:
    """The estimator of a vehicle model."""
    form, car = relative_form(model), model.effects["quarter_car"]
    at = int(np.argmax(np.abs(form.B)))
    noise = (model.rig["acceleration_noise"], model.rig["deflection_noise"])
    numbers = np.array([
        car["m_s"], car["k_s"], form.F[0], form.F[1], -form.B[at] / form.A[at, at],
        -form.A[at, at], *form.Gamma[:2], *noise, arrival, sharp,
    ])  # fmt: skip
    made = Horizon(numbers, round(samples))
    rest = Sample(0.0, 0.0, 0.0, 0.0, 0.0)
    step(made, start(made, rest), rest._replace(t=0.005))
    return made


def start(p: Horizon, sample: Sample, x: Array | None = None) -> State:
    """State at the first sample: rest, or x (4,)."""
    del p
    t, sprung, unsprung, duty, seen = sample
    first = np.array([seen, 0.0, 0.0]) if x is None else np.array([seen, x[1], x[3]])
    rows = np.array([[t, sprung - unsprung, sprung, seen, duty]])
    return State(rows, first, Estimate(0.0, seen, 0.0, Status.INITIALISING, 0.0, ""))


def step(p: Horizon, state: State, sample: Sample) -> tuple[State, Estimate]:
    """Estimate at the time of this sample; what is no number changes nothing."""
    t, sprung, unsprung, duty, seen = sample
    if not math.isfinite(sprung + unsprung + seen) or t <= state.rows[-1, 0]:
        return state, state.estimate
    duty = duty if math.isfinite(duty) else float(state.rows[-1, 4])
    rows = np.vstack([state.rows, [t, sprung - unsprung, sprung, seen, duty]])
    first = state.first
    if len(rows) > p.samples:
        first, rows = along(p.numbers, rows[:2], first), rows[1:]
    first, last = solved(p.numbers, np.ascontiguousarray(rows), first)
    force = float(p.numbers[2] * last[0] + p.numbers[3] * last[1] + last[2])
    estimate = Estimate(force, float(last[0]), float(last[1]), Status.OK, 0.0, "")
    return State(rows, first, estimate), estimate
