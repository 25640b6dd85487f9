"""Automatic scaling: interior-point solvers need numbers near one, and SI units are far from that.

Sizes are standard deviations of the passive car on a road with white velocity, scaled so that the
deflection velocity is a third of the model's envelope; the yield force gets half its height at the
envelope's duty; the unit of time is the geometric mean of the passive poles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from er_models.linear import LinearForm, thesis_form
from er_models.model import Array, Model
from scipy.linalg import solve_continuous_lyapunov


@dataclass(frozen=True, eq=False)
class Scaling:
    """Typical sizes: state (n,), output (m,) [SI], and rate [1/s], the inverse unit of time."""

    state: Array
    output: Array
    rate: float


def scaling_of(model: Model, form: LinearForm) -> Scaling:
    """Scaling of a vehicle model in the coordinates of `form`."""
    car = thesis_form(model)
    road = np.outer(car.D1, car.D1)
    covariance = solve_continuous_lyapunov(car.A, -road)
    velocity = np.array([0.0, 1.0, 0.0, -1.0, 0.0])
    typical = (model.scales.velocity / 3.0) ** 2 / (velocity @ covariance @ velocity)
    covariance = covariance * typical
    covariance[4, 4] = (0.5 * model.scales.duty * car.B[4] / car.A[4, 4]) ** 2
    sizes = np.sqrt(np.diag(form.chart @ covariance @ form.chart.T))
    outputs = np.sqrt(np.diag(car.C @ covariance @ car.C.T))
    poles = np.abs(np.linalg.eigvals(car.A))
    rate = np.exp(np.mean(np.log(poles), keepdims=True))
    return Scaling(_round(sizes), _round(outputs), float(_round(rate)[0]))


def _round(values: Array) -> Array:
    """Two significant digits: a scaling needs no more, and they are the same on every machine."""
    return np.array([float(f"{v:.2g}") for v in values])
