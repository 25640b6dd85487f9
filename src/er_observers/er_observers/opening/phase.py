"""The first moments of an observer: what its start is worth, and when it is good enough.

A constant gain forgets a wrong start no faster than it follows the road. An observer that knows
how wrong its start may be can do better: while the doubt about the deflection still costs force,
its gain is that of a Kalman filter (`filter`), which falls as the doubt does. Then the proved gain
takes over, from the state reached; it converges from wherever it is put, so its certificate needs
nothing of this. An extended filter is cheaper and leaves a third more error: what it makes of a
start depends on which side of the gate it believes the damper to be.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from er_models.constants import SAMPLE_TIME
from er_models.errors import InputError
from er_models.linear import LinearForm
from er_models.model import Array, Model

from er_observers.filters.flow import noise_covariance
from er_observers.observers.phi import phi_functions
from er_observers.opening.filter import start_sample
from er_observers.scaling import road_density

SUBSTEPS = 2
PERIOD = SAMPLE_TIME
"""Sample time that the process noise is computed for; other times take their share of it [s]."""
ROAD = 0.35
"""Share of the road's density that ISO roads have: it is stated for a third of the velocity's envelope."""
WRONG = 2.0 / 3.0
"""Share of the envelope that all but the deflection may be wrong by at the start."""
ENOUGH = 0.015
"""Share of the force envelope that the doubt about the deflection may cost when the gain takes over."""


FARTHEST = 3.0
"""Farthest start that is taken, in standard deviations of what the envelope leaves in doubt: from there on the phase
ends before the start is found, and what is wrong by more than 2 % is called OK."""


class Opening(NamedTuple):
    """Constants of the start phase.

    A (n, n), B (n,) at duty 1, Gamma (n,), C (m, n): the form. variance (m,): of the outputs.
    noise (n, n): covariance that the road adds in a substep of `PERIOD`. prior (n, n): covariance
    of the start. cost (n,): force error per state error when the sprung acceleration is explained [N].
    limit: force [N] that the doubt may cost at the end.
    """

    A: Array
    B: Array
    Gamma: Array
    C: Array
    variance: Array
    noise: Array
    prior: Array
    cost: Array
    limit: float


def spread_of(model: Model, form: LinearForm) -> Array:
    """Standard deviations (n,) of a start in the coordinates of `form` [SI].

    The start may be wrong by the model's envelope: its deflection, and two thirds of its velocity,
    of the tyre deflection that carries its force and of the yield force at its duty.
    """
    s, at = model.scales, int(np.argmax(np.abs(form.B)))
    tyre = s.force / abs(float(form.C[1, 2] * form.F[at] / form.C[1, at]))
    yielding = s.duty * abs(float(form.B[at] / form.A[at, at]))
    return np.array([s.deflection, *(WRONG * np.array([s.velocity, tyre, yielding]))])


def check_start(states: tuple[str, ...], spread: Array, x: Array) -> None:
    """`InputError` where a given start x (n,) [SI] is none that the envelope's `spread` (n,) allows."""
    if np.shape(x) != spread.shape:
        raise InputError("start", "x", f"{', '.join(states)}", f"shape {np.shape(x)}")
    for name, most, found in zip(states, FARTHEST * spread, x, strict=True):
        if not abs(found) <= most:
            expected = (
                f"-{most:.3g} to {most:.3g} [SI], {FARTHEST:g} deviations of the model's envelope"
            )
            raise InputError("start", f"x: {name}", expected, f"{found:.6g}")


def opening_of(model: Model, form: LinearForm, noise: float) -> Opening:
    """Start phase of a vehicle model in the coordinates of `form`; noise of the accelerometers [m/s2]."""
    s, at = model.scales, int(np.argmax(np.abs(form.B)))
    cost = form.F - form.C[0] * (form.F[at] / form.C[0, at])
    noise_of_road = noise_covariance(
        form, ROAD * road_density(model) * form.D1**2, PERIOD / SUBSTEPS
    )
    A, B, gamma, C = (np.ascontiguousarray(m) for m in (form.A, form.B, form.Gamma, form.C))
    return Opening(
        A, B, gamma, C,
        variance=np.full(C.shape[0], noise**2),
        noise=noise_of_road,
        prior=np.diag(spread_of(model, form) ** 2),
        cost=cost,
        limit=ENOUGH * s.force,
    )  # fmt: skip


def follow(
    opening: Opening, x: Array, P: Array, duty: float, dt: float, y: Array
) -> tuple[Array, Array]:
    """State (n,) and covariance (n, n) dt [s] later, corrected by y (m,) where it is finite."""
    h = dt / SUBSTEPS
    phi = phi_functions(h * opening.A)
    kick, noise = h * (phi[1] @ opening.B), dt / PERIOD * opening.noise
    x, P = x.copy(), P.copy()
    start_sample(
        phi[0], kick, opening.Gamma, noise, opening.C, opening.variance,
        duty, SUBSTEPS if dt > 0.0 else 0, y, x, P,
    )  # fmt: skip
    return x, P


def finished(opening: Opening, P: Array) -> bool:
    """Whether the doubt about the state costs little force."""
    return bool(opening.cost @ P @ opening.cost < opening.limit**2)
