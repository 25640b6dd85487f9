r"""Momentum observer: what changes the body's momentum beside its spring, through a first-order lag.

.. math::  r = L \left(p + \int (k_s x + r)\,dt\right), \quad p = m_s v_s \;\Rightarrow\; r' = L (-m_s a_s - k_s x - r)

with an accelerometer in place of the velocity, whose drift the difference of both integrals would hold.

Source: De Luca and Mattone 2003.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from er_models.model import Array, Model
from er_observers.running.runtime import Estimate, Sample

from er_studies.observers.peers import balance

TUNED = {"bandwidth": (30.0, 3000.0)}
"""What is tuned, with bounds: L [1/s]."""


class Momentum(NamedTuple):
    """The body and the gain L [1/s]."""

    body: balance.Balance
    bandwidth: float


class State(NamedTuple):
    """Time of the last sample [s], what the body's balance said then, the estimate."""

    t: float
    now: float
    estimate: Estimate


def make(model: Model, bandwidth: float) -> Momentum:
    """The observer of a vehicle model."""
    return Momentum(balance.make(model), bandwidth)


def start(p: Momentum, sample: Sample, x: Array | None = None) -> State:
    """State at the first sample: the balance."""
    first = balance.start(p.body, sample, x).estimate
    return State(sample.t, first.force, first)


def step(p: Momentum, state: State, sample: Sample) -> tuple[State, Estimate]:
    """Estimate at the time of this sample; the balance is straight in between."""
    now, dt = balance.start(p.body, sample).estimate, sample.t - state.t
    if not (dt > 0.0 and math.isfinite(now.force)):
        return state, state.estimate
    a = p.bandwidth * dt
    fade = math.exp(-a)
    ramp = (now.force - state.now) / a
    force = now.force - ramp + fade * (state.estimate.force - state.now + ramp)
    estimate = now._replace(force=force)
    return State(sample.t, now.force, estimate), estimate
