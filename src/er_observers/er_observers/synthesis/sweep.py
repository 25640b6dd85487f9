"""L2 gain of the error by frequency sweep, the gate frozen at slopes of its sector.

A bound from below that shares nothing with the inequalities: a gamma under it would show an error
in either.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from er_models.forms.response import frequency_response
from er_models.model import Array

from er_observers.synthesis.proof import Claim


class Peak(NamedTuple):
    """Largest gain from weighted (w, n) to the output; frequency [rad/s], duty, slope there."""

    gain: float
    omega: float
    rho: float
    slope: float


def peak_gain(claim: Claim) -> Peak:
    """Peak over frequency, duty (nodes and between) and slope of the gate (0 to 1)."""
    omega = np.concatenate([[0.0], np.logspace(-3, 6, 361)])
    law, e, noise = claim.solution.law, claim.error, claim.spec.noise_matrix()
    road = law.T @ claim.spec.input_matrix(claim.form)
    worst = Peak(0.0, 0.0, 0.0, 0.0)
    for rho in np.linspace(law.rho[0], law.rho[-1], 9):
        M, J = law.at(float(rho))
        for slope in (0.0, 0.01, 0.1, 0.3, 1.0):
            gate = slope * rho * e.b
            gains = response(M + gate @ e.G, road - J @ noise + gate @ e.G_w, e.H, e.H_w, omega)
            at = int(np.argmax(gains))
            if gains[at] > worst.gain:
                worst = Peak(float(gains[at]), float(omega[at]), float(rho), float(slope))
    return worst


def response(A: Array, B: Array, C: Array, D: Array, omega: Array) -> Array:
    """Largest singular values (k,) of C (j omega - A)^-1 B + D at frequencies (k,) [rad/s]."""
    answers = frequency_response(A, B, C, omega / (2.0 * np.pi), D)
    return np.asarray(np.linalg.svd(answers, compute_uv=False)[:, 0])
