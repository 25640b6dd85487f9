r"""Gains of the state feedback: a linear-quadratic regulator of car and yield force for each regime of the road.

.. math::  \int (\ddot z_s / w_a)^2 + (z_{def} / w_x)^2 + (\dot z_s / w_v)^2 + (z_t / w_t)^2 + (c / w_c)^2 \, dt,
           \quad \tau \dot F_{er} = c - F_{er}

The state [z_def, z_s', z_t, z_us', F_er] holds the yield force, so the goal c = -K s that the duty sets makes up for
the lag of the fluid. Sizes that count as one are shares of those of a body that swings by the stroke at its own
frequency; so a car of another size is weighed at its own.

Source: Hrovat 1997, Survey of advanced suspension developments, Automatica 33 (10); clipping: Karnopp 1983.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass
from typing import NamedTuple

import numpy as np
from er_models.errors import InputError
from er_models.forms.lipschitz import linearise
from er_models.forms.loss import Factors, damaged
from er_models.forms.lti import lti_form
from er_models.model import Array, Model
from er_models.static_damper import HEALTHY
from scipy.linalg import LinAlgError, solve_continuous_are

from er_ftc_controller.state_law import LEAKING, Shares
from er_ftc_controller.synthesis.weights import body_frequency

REGIMES = Shares._fields
"""Below the body's frequency; about it, alone; on a road of many frequencies; there with a damper that leaks."""
CORNER = 0.03
"""Corner of the leaky integral of the acceleration, over the body's frequency."""


@dataclass(frozen=True)
class StateWeights:
    """Sizes that count as one: acceleration, deflection, velocity of the body, tyre's deflection, goal of the force."""

    acceleration: float
    deflection: float
    velocity: float
    tyre: float
    goal: float

    def __post_init__(self) -> None:
        if not all(value > 0.0 for value in astuple(self)):
            raise InputError("state weights", "sizes", "numbers above 0", astuple(self))


@dataclass(frozen=True)
class StateDesign:
    """What the gains of the regimes are made of: of `slow` the damping of the body [1], of the others the weights.

    The damping counts in sprung masses times the body's frequency [rad/s]. `leaking` is weighed on the car that a leak
    leaves, where less damping forgives less that samples come late: so its goal counts more.
    """

    slow: float = 0.33
    resonance: StateWeights = StateWeights(1.0, 1.03, 0.63, 5.6, 2.55)
    rough: StateWeights = StateWeights(1.0, 1.5, 1000.0, 1.3, 5.0)
    leaking: StateWeights = StateWeights(1.0, 1.5, 1000.0, 1.3, 2.0)


class Sizes(NamedTuple):
    """The body's frequency [Hz] and sizes of its swing by the stroke, as of `StateWeights` [m/s2, m, m/s, m, N]."""

    frequency: float
    units: tuple[float, float, float, float, float]


def sizes_of(model: Model) -> Sizes:
    """Sizes of a vehicle; raises as `lti_form`."""
    frequency, stroke, car = (
        body_frequency(lti_form(model)),
        model.scales.deflection,
        model.effects["quarter_car"],
    )
    omega = 2.0 * np.pi * frequency
    force = car["m_s"] * omega**2 * stroke
    return Sizes(frequency, (omega**2 * stroke, stroke, omega * stroke, force / car["k_t"], force))


def state_gains(model: Model, design: StateDesign) -> tuple[Array, Array, Array, Array]:
    """Gains (5,) of the regimes; raises as `state_gain`."""
    _, (_, _, velocity, _, force) = sizes_of(model)
    slow = np.array([0.0, -design.slow * force / velocity, 0.0, 0.0, 0.0])
    leaking = state_gain(model, design.leaking, Factors(leakage=LEAKING))
    return slow, state_gain(model, design.resonance), state_gain(model, design.rough), leaking


def car_of(model: Model, left: Factors) -> tuple[Array, Array, Array]:
    """A (5, 5), B (5,) of the goal c [N] and D (5,) of the road's rate, with the passive force that faults leave."""
    form = linearise(damaged(model, left))
    lag = -float(form.A[4, 4])
    return form.A, np.array([0.0, 0.0, 0.0, 0.0, lag]), form.D1


def state_gain(model: Model, weights: StateWeights, left: Factors = HEALTHY) -> Array:
    """Gain K (5,) of c = -K s for the car that faults leave, the body's velocity forgotten at `CORNER`.

    Raises `InputError` where the model has no lag, no linear form, or no gain solves the problem.
    """
    frequency, units = sizes_of(model)
    A, B, _ = car_of(model, left)
    a, x, v, tyre, goal = (w * u for w, u in zip(astuple(weights), units, strict=True))
    forgets = A - 2.0 * np.pi * CORNER * frequency * np.diag([0.0, 1.0, 0.0, 0.0, 0.0])
    rows = np.vstack([A[1] / a, np.eye(5)[0] / x, np.eye(5)[1] / v, np.eye(5)[2] / tyre])
    try:
        P = solve_continuous_are(forgets, B[:, None], rows.T @ rows, np.array([[goal**-2]]))
    except (LinAlgError, ValueError) as error:
        raise InputError(
            model.name, "weights", "weights that a gain solves", str(error)
        ) from error
    return np.asarray(B @ P * goal**2)
