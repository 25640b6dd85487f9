r"""The generalised plant of the LPV controller: suspension (2.8), weights and noise of the sensor, in scaled units.

.. math::  z_1 = k_s \frac{\omega_s}{s + \omega_s} \frac{z_s}{r}, \quad
           z_2 = k_u \frac{\omega_u}{s + \omega_u} \frac{z_{us}}{r}, \quad
           z_3 = \rho \frac{\omega_f}{s + \omega_f} \frac{u_{er}}{f}, \quad y = z_{def} + n

with z_r = r w. Only the row of z_3 depends on rho. Behind a filter (the thesis's 50 Hz) the force is a state, so a
shared Lyapunov matrix bounds it at the lowest rho by what is allowed at the greatest; without one (corner
infinite) each vertex has its own force. Then z_3 between the vertices is, for the proof, the mean of theirs.

Source: thesis 6.3.1.1, (6.18); road r and force f in sizes of their own and the sensor's noise are ours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from er_models.errors import InputError
from er_models.forms.lti import LTIForm, lti_form
from er_models.model import Array, Model
from scipy.linalg import block_diag

INPUTS, OUTPUTS = ("road", "noise"), ("comfort", "road holding", "force")


@dataclass(frozen=True)
class Weights:
    """Weights of the generalised plant.

    road r: height that counts as one [m]; body, wheel, actuator: corner [Hz] and gain [1], the actuator's corner
    may be infinite; force f: that counts as one [N]; noise: of the deflection, that counts as one [m]; rho: range of
    the scheduling parameter; tyre: whether z_2 weighs z_us - z_r, which has no floor at zero frequency, not z_us.
    """

    road: float
    body: tuple[float, float]
    wheel: tuple[float, float]
    actuator: tuple[float, float]
    force: float
    noise: float
    rho: tuple[float, float]
    tyre: bool = False

    def __post_init__(self) -> None:
        positive = (self.road, *self.body, *self.wheel, *self.actuator, self.force)
        if not all(value > 0.0 for value in positive) or self.noise < 0.0:
            raise InputError("weights", "values", "numbers above 0", positive)
        if not 0.0 < self.rho[0] < self.rho[1]:
            raise InputError("weights", "rho", "0 < low < high", self.rho)


W_ROAD = 0.07
"""W_zr of 6.3.1.1: gamma of the thesis is this times ours, which counts outputs in heights of the road."""
THESIS = Weights(W_ROAD, (4.0, 2.0), (20.0, 1.0), (50.0, 1.0), W_ROAD, 0.0, (0.01, 1.0))
"""Weights of 6.3.1.1: W_zr as the height of the road, 1 N for 1 m."""


COMFORT, HOLDING = 2.33, 1.165
"""Corners of comfort and road holding over the body's natural frequency: 10 and 5 Hz for the thesis's car."""
RADIUS = 1.126
"""Largest magnitude of every pole over that of the fastest one without control: 250 1/s for the thesis's car."""


def weights_for(model: Model) -> Weights:
    """Our weights, in the frequency of a model's body and the sizes of its envelope; raises as `lti_form`.

    Comfort weighs up to 10 Hz for the thesis's car, whose body has 4.3 Hz, instead of from zero frequency to 4 Hz; road
    holding weighs the tyre's deflection up to 5 Hz; the road is as high as the stroke, a quarter of the damper's force
    counts as one.
    """
    s, body = model.scales, body_frequency(lti_form(model))
    comfort, holding = (float(f"{share * body:.3g}") for share in (COMFORT, HOLDING))
    return Weights(
        s.deflection, (comfort, 1.0), (holding, 6.0), (np.inf, 1.0), 0.25 * s.force, 0.01 * s.deflection,
        (0.2, 5.0), tyre=True,
    )  # fmt: skip


def body_frequency(form: LTIForm) -> float:
    """Natural frequency of the body without control [Hz]: of the two slowest poles, which need not swing."""
    slow = np.sort(np.abs(np.linalg.eigvals(form.A)))[:2]
    return float(np.sqrt(slow.prod())) / (2.0 * np.pi)


def radius_for(model: Model) -> float:
    """Our disc of poles [1/s], in the frequency of a model's wheel; raises as `lti_form`."""
    fastest = float(np.abs(np.linalg.eigvals(lti_form(model).A)).max())
    return float(f"{RADIUS * fastest:.3g}")


@dataclass(frozen=True, eq=False)
class Plant:
    """Generalised plant: A (n, n), B1 (n, 2), B2 (n, 1), C1 (3, n), D12 (3, 1), C2 (1, n), D21 (1, 2).

    In units of r, 1 / rate [s] and, of the controller's force, unit [N]. C1 and D12 are those of rho = 1.
    """

    A: Array
    B1: Array
    B2: Array
    C1: Array
    D12: Array
    C2: Array
    D21: Array
    rate: float
    unit: float
    weights: Weights
    form: LTIForm

    @property
    def n(self) -> int:
        """Number of states."""
        return int(self.A.shape[0])

    def outputs(self, rho: float) -> tuple[Array, Array]:
        """C1 (3, n) and D12 (3, 1) at a scheduling parameter."""
        by = np.array([[1.0], [1.0], [rho]])
        return self.C1 * by, self.D12 * by


def generalised_plant(model: Model, weights: Weights) -> Plant:
    """The plant (6.18) of a vehicle model; raises as `lti_form`.

    Its unit of time is the inverse mean size of the passive poles, its force moves a mass by r in that time:
    solvers need numbers near one, which SI units are far from.
    """
    form, w = lti_form(model), weights
    rate = float(np.exp(np.mean(np.log(np.abs(np.linalg.eigvals(form.A))))))
    sizes = w.road * np.array([1.0, rate, 1.0, rate])
    A = form.A * sizes / sizes[:, None] / rate
    B, D = form.B / sizes / rate, form.D * w.road / sizes / rate
    unit = float(1.0 / np.abs(B).max())
    filters = [pair for pair in (w.body, w.wheel, w.actuator) if np.isfinite(pair[0])]
    corners = [2.0 * np.pi * hertz / rate for hertz, _ in filters]
    n, through = 4 + len(filters), w.actuator[1] * unit / w.force
    whole = block_diag(A, *(-corner * np.eye(1) for corner in corners))
    whole[4, 0], whole[5, 2] = corners[0], corners[1]
    road = np.append(D, np.zeros(n - 4))
    if w.tyre:
        road[5] = -corners[1]
    B2, C1, C2 = np.zeros((n, 1)), np.zeros((3, n)), np.zeros((1, n))
    B2[:4, 0] = B * unit
    C1[0, 4], C1[1, 5] = w.body[1], w.wheel[1]
    C2[0, [0, 2]] = 1.0, -1.0
    if n == 7:
        B2[6], C1[2, 6], through = corners[2], through, 0.0
    return Plant(
        A=whole,
        B1=np.column_stack([road, np.zeros(n)]),
        B2=B2, C1=C1, D12=np.array([[0.0], [0.0], [through]]),
        C2=C2, D21=np.array([[0.0, w.noise / w.road]]), rate=rate, unit=unit, weights=w, form=form,
    )  # fmt: skip
