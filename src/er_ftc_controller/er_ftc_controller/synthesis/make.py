"""From a vehicle and a wish to a proved controller: one call."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from er_models.model import Model

from er_ftc_controller.synthesis.certificate import Certificate, certify
from er_ftc_controller.synthesis.lmi import Wish, solve
from er_ftc_controller.synthesis.solution import Solution
from er_ftc_controller.synthesis.state_lqr import CORNER, StateDesign, sizes_of, state_gains
from er_ftc_controller.synthesis.state_proof import Feedback, law_of, loops_of
from er_ftc_controller.synthesis.state_solve import prove
from er_ftc_controller.synthesis.weights import (
    Plant,
    Weights,
    generalised_plant,
    radius_for,
    weights_for,
)


class Design(NamedTuple):
    """The plant a controller was made for, the controller, and what is known of it without trusting the solver."""

    plant: Plant
    solution: Solution
    certificate: Certificate


def synthesise(model: Model, weights: Weights | None = None, wish: Wish | None = None) -> Design:
    """The LPV controller of a vehicle, proved and certified; `save_gains` writes it.

    weights, wish: of comfort, road holding and force; the disc of the poles. None: those that suit the vehicle.

    Raises:
        NoController: There is none, or what the solver found is none; it names what fails.
        ErError: The model is no vehicle with a damper.
    """
    plant = generalised_plant(model, weights or weights_for(model))
    solution = solve(plant, wish or Wish(radius_for(model)))
    return Design(plant, solution, certify(plant, solution))


def synthesise_feedback(model: Model, design: StateDesign | None = None) -> Feedback:
    """The state feedback of a vehicle, proved.

    Raises:
        NoController: No quadratic function bears its gains and faults.
        ErError: The model is no vehicle with a damper that lags.
    """
    corner = float(f"{2.0 * np.pi * CORNER * sizes_of(model).frequency:.4g}")
    gains = np.array(state_gains(model, design or StateDesign()))
    return Feedback(law_of(model, gains, corner), prove(loops_of(model, list(gains), corner)))
