r"""The gate as an uncertain slope: the LFT treatment, and a second way to the incremental gain.

The difference of two gates is ``d = delta(t) s`` with 0 <= delta <= 1, a linear fractional
transformation with one scalar block. The error is then linear,

.. math::  \zeta' = (M + \delta \rho\, b G) \zeta + (W + \delta \rho\, b G_w) w

and, as delta enters affinely, one P for delta = 0 and delta = 1 at every node proves an L2 gain however
delta and the duty move. There is no multiplier and no column of the gate: the inequalities share
nothing with `lmi` but V. By the S-lemma the slope restriction asks for no more than this, so both
must find the same gamma; the Lipschitz bound, |delta| <= 1, asks for more.

Source: Boyd, El Ghaoui, Feron and Balakrishnan 1994, sections 5.1 and 6.3.
"""

from __future__ import annotations

import cvxpy as cp
import numpy as np

from er_observers.synthesis.proof import Claim
from er_observers.synthesis.solver import SOLVER, blocks, run
from er_observers.synthesis.spec import SynthesisFailed

_TRACES = (0.0, 1e-8, 1e-6, 1e-4, 1e-3)
"""Shares of every scaled state in the output, tried in turn: what no output shows makes P singular."""


def vertex_gain(claim: Claim, low: float = 0.0, solver: str = SOLVER) -> float:
    """Smallest gamma that one P proves for slopes from `low` to 1 of the gate and every duty.

    NaN where the solver gives no answer. Raises `SynthesisFailed` where it says that there is no P.
    """
    for trace in _TRACES:
        gamma_2, constraints = _problem(claim, low, trace)
        status = run(cp.Problem(cp.Minimize(gamma_2), constraints), solver)
        if "optimal" in status and float(np.asarray(gamma_2.value)) > 0.0:
            return float(np.sqrt(np.asarray(gamma_2.value)))
        if status == cp.INFEASIBLE:
            reason = f"no common P for slopes from {low:g} to 1 of the gate"
            raise SynthesisFailed("vertices of the gate's slope", reason, status)
    return float("nan")


def _problem(claim: Claim, low: float, trace: float) -> tuple[cp.Variable, list[cp.Constraint]]:
    """Gamma squared and the inequalities, with a trace of every state added to the output."""
    e, law, z = claim.error, claim.solution.law, claim.sizes
    rate = claim.scaling.rate
    H, H_w = e.H * z, e.H_w
    P, gamma_2 = cp.Variable((len(z), len(z)), symmetric=True), cp.Variable()
    constraints: list[cp.Constraint] = [P >> 0]
    for rho, M, W in zip(law.rho, law.M, e.W, strict=True):
        for delta in (low, 1.0):
            loop = delta * rho * e.b
            decay = P @ ((M + loop @ e.G) * z / z[:, None] / rate)
            entry = P @ ((W + loop @ e.G_w) / z[:, None] / rate) + H.T @ H_w
            corner = H_w.T @ H_w - gamma_2 * np.eye(W.shape[1])
            whole = decay + decay.T + H.T @ H + trace * np.eye(len(z))
            constraints.append(blocks([[whole, entry], [entry.T, corner]]) << 0)
    return gamma_2, constraints
