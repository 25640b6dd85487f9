r"""From road, noise and gate to the error of the estimate, at frozen duties.

.. math::  \zeta' = M \zeta + T D_1 \omega_r - J \omega_n + T B \rho\, d, \quad
           x - \hat x = R \zeta - S \omega_n

d is the difference of the gates, an input here. The noise counts in units of `NOISE`, as in the thesis.

Source: thesis (3.51), (4.49), figures 3.1-3.2, 4.1-4.8, 5.1-5.4.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from er_models.forms.nlpv import NOISE
from er_models.forms.response import frequency_response
from er_models.model import Array
from er_observers.synthesis.proof import Claim

INPUTS = ("road", "noise", "gate")
HERTZ = np.logspace(-2, 3, 301)
"""Frequencies of the thesis's figures and some more [Hz]."""


class Response(NamedTuple):
    """Gains of one observer at one duty.

    gains (k, outputs): from the input to each state's error, the largest over the input's
    channels, and to the force's error, the last; sigma (k,): largest singular value to all states.
    """

    observer: str
    duty: float
    gains: Array
    sigma: Array


def outputs(claim: Claim) -> tuple[str, ...]:
    """Names of the errors."""
    return (*claim.form.states, "force")


def respond(
    observer: str, claim: Claim, duty: float, source: str, hertz: Array = HERTZ
) -> Response:
    """Response at a duty to one of `INPUTS`, over frequencies (k,) [Hz]."""
    law, form = claim.solution.law, claim.form
    M, J = law.at(duty)
    n, through = form.n, np.zeros((form.n, 1))
    if source == "road":
        entry = (law.T @ form.D1)[:, None]
    elif source == "gate":
        entry = (law.T @ form.B)[:, None] * duty
    else:
        unit = np.diag([*NOISE, *[claim.spec.noise[-1]] * (form.C.shape[0] - len(NOISE))])
        entry, through = -J @ unit, -law.S @ unit
    rows = np.vstack([np.eye(n), form.F])
    answer = frequency_response(M, entry, rows @ law.R, hertz, rows @ through)
    gains = np.abs(answer).max(axis=2)
    sigma = np.linalg.svd(answer[:, :n], compute_uv=False)[:, 0]
    return Response(observer, duty, gains, np.asarray(sigma, np.float64))
