"""Direct balance: F = -m_s a_s - k_s z_def, no damper model and no memory."""

from __future__ import annotations

import math
from typing import NamedTuple

from er_models.model import Array, Model
from er_observers.observers.status import Status
from er_observers.running.runtime import Estimate, Sample

TUNED: dict[str, tuple[float, float]] = {}
"""What is tuned, with bounds: nothing."""


class Balance(NamedTuple):
    """Sprung mass [kg] and stiffness of its spring [N/m]."""

    m_s: float
    k_s: float


class State(NamedTuple):
    """The last estimate."""

    estimate: Estimate


def make(model: Model) -> Balance:
    """The balance of a vehicle model's body."""
    car = model.effects["quarter_car"]
    return Balance(car["m_s"], car["k_s"])


def start(p: Balance, sample: Sample, x: Array | None = None) -> State:
    """State at the first sample; x is not needed."""
    del x
    return step(p, State(Estimate(0.0, 0.0, 0.0, Status.INVALID, 0.0, "")), sample)[0]


def step(p: Balance, state: State, sample: Sample) -> tuple[State, Estimate]:
    """Estimate of this sample alone; not valid without a deflection."""
    force = -p.m_s * sample.sprung_acceleration - p.k_s * sample.deflection
    if not math.isfinite(force):
        return state, state.estimate._replace(status=Status.INVALID)
    estimate = Estimate(force, sample.deflection, 0.0, Status.OK, 0.0, "")
    return State(estimate), estimate
