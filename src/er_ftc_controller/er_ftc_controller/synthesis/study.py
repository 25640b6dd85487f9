"""What a controller does to the car, over frequency, and what the choices of its design cost."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from er_models.forms.passive import passive_response
from er_models.forms.response import frequency_response
from er_models.model import Array, Model

from er_ftc_controller.synthesis.certificate import closed_loop
from er_ftc_controller.synthesis.lmi import passive_gamma, smallest
from er_ftc_controller.synthesis.solution import Vertex
from er_ftc_controller.synthesis.weights import Plant, Weights, generalised_plant

HERTZ = np.geomspace(0.1, 60.0, 800)
COMFORT, HOLDING = (1.0, 10.0), (1.0, 5.0)
"""Bands of body and wheel [Hz] that the thesis reads its figures 6.16 and 6.17 by."""
RHO_MAX = (1.0, 5.0, 20.0)
ALLOWED = (1.03, 1.1, 1.3)


class Peaks(NamedTuple):
    """Largest gains over z_r: body 1 to 10 Hz, wheel 1 to 5 Hz, wheel at any frequency."""

    body: float
    wheel: float
    wheel_anywhere: float


def gains(plant: Plant, k: Vertex, hertz: Array = HERTZ) -> Array:
    """|z_s|, |z_us|, |z_def| over z_r with the controller of one vertex (k, 3)."""
    A, B, _ = closed_loop(plant, k)
    rows = np.zeros((3, A.shape[0]))
    rows[[0, 1, 2, 2], [0, 2, 0, 2]] = 1.0, 1.0, 1.0, -1.0
    response = frequency_response(A * plant.rate, B[:, :1] * plant.rate, rows, hertz)
    return np.abs(response[:, :, 0])


def passive_gains(model: Model, hertz: Array = HERTZ) -> Array:
    """The same of the car without control."""
    return np.abs(passive_response(model, hertz))


def peaks(found: Array, hertz: Array = HERTZ) -> Peaks:
    """Peaks of gains (k, 3)."""

    def largest(column: int, band: tuple[float, float]) -> float:
        return float(found[(hertz >= band[0]) & (hertz <= band[1]), column].max())

    return Peaks(largest(0, COMFORT), largest(1, HOLDING), float(found[:, 1].max()))


def trade_off(
    model: Model, weights: Weights, radius: float, tick: Callable[[str], None] | None = None
) -> list[tuple[float, float, float]]:
    """Rows (greatest rho, gamma allowed there over passive, least gamma at the lowest rho over passive)."""
    rows = []
    for high in RHO_MAX:
        plant = generalised_plant(model, replace(weights, rho=(weights.rho[0], high)))
        passive = passive_gamma(plant)
        for allowed in ALLOWED:
            if tick:
                tick(f"trade-off, rho to {high:g}, {allowed:g} x passive")
            least = smallest(plant, plant.weights.rho, radius, allowed * passive)
            rows.append((high, allowed, least / passive))
    return rows
