"""Automatic scaling: interior-point solvers need numbers near one, and SI units are far from that.

Sizes are standard deviations of the passive car on a road with white velocity, scaled so that the
deflection velocity is a third of the model's envelope; the yield force gets half its height at the
envelope's duty; the unit of time is the geometric mean of the passive poles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from er_models.linear import LinearForm, linearise
from er_models.model import Array, Model

_UNDAMPED = 1e-6
"""Share of the fastest pole below which the slowest counts as not decaying."""


@dataclass(frozen=True, eq=False)
class Scaling:
    """Typical sizes: state (n,), output (m,) [SI], and rate [1/s], the inverse unit of time."""

    state: Array
    output: Array
    rate: float


def road_density(model: Model) -> float:
    """Density [m2/s] of the white road velocity that moves the passive car over its envelope.

    The deflection velocity then has a third of the envelope as its standard deviation.
    """
    return _passive_ride(model)[1]


def scaling_of(model: Model, form: LinearForm) -> Scaling:
    """Scaling of a vehicle model in the coordinates of `form`."""
    car = linearise(model)
    unit, density = _passive_ride(model)
    covariance = unit * density
    covariance[4, 4] = (0.5 * model.scales.duty * car.B[4] / car.A[4, 4]) ** 2
    covariance = form.chart @ covariance @ form.chart.T
    sizes = np.sqrt(np.diag(covariance))
    outputs = np.sqrt(np.diag(form.C @ covariance @ form.C.T))
    poles = np.abs(np.linalg.eigvals(car.A))
    rate = np.exp(np.mean(np.log(poles), keepdims=True))
    return Scaling(_round(sizes), _round(outputs), float(_round(rate)[0]))


def _passive_ride(model: Model) -> tuple[Array, float]:
    """Covariance (5, 5) of the passive car for a road velocity of density one, and the density for its envelope.

    A car without damping has no stationary ride; its poles are then moved to the left, as far as a ride is long.
    """
    car = linearise(model)
    poles = np.linalg.eigvals(car.A)
    A, size = car.A, float(np.abs(poles).max())
    if poles.real.max() > -_UNDAMPED * size:
        A = A - 1e3 * _UNDAMPED * size * np.eye(len(A))
    covariance = _stationary(A, np.outer(car.D1, car.D1))
    velocity = np.array([0.0, 1.0, 0.0, -1.0, 0.0])
    density = (model.scales.velocity / 3.0) ** 2 / (velocity @ covariance @ velocity)
    return covariance, float(density)


def _stationary(A: Array, Q: Array) -> Array:
    """X (n, n) with A X + X A' + Q = 0, as the linear equations that this is.

    SciPy's solver would do as well, but nodes come here, and its import takes a third of their start.
    """
    unit = np.eye(len(A))
    X = np.linalg.solve(np.kron(A, unit) + np.kron(unit, A), -Q.ravel())
    return np.asarray(X.reshape(A.shape))


def _round(values: Array) -> Array:
    """Two significant digits: a scaling needs no more, and they are the same on every machine."""
    return np.array([float(f"{v:.2g}") for v in values])
