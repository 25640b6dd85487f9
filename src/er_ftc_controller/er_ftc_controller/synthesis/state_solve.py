"""The matrices of `state_proof`, as a solver finds them."""

from __future__ import annotations

from typing import cast

import cvxpy as cp
import numpy as np
from cvxpy.atoms.affine.bmat import bmat
from cvxpy.atoms.affine.sum import sum as total
from er_models.constants import SAMPLE_TIME
from er_models.model import Array

from er_ftc_controller.synthesis.solution import NoController
from er_ftc_controller.synthesis.state_proof import Loops, StateProof, failed, sampled

SLACK = 1.02
"""What every gamma is given beyond the least, for margins that survive rounding."""


def prove(loops: Loops, sample: float = SAMPLE_TIME) -> StateProof:
    """One function for all loops, each gain's gamma as small as their sum allows, and one for all sampled loops.

    Raises `NoController` where there is none, or what the solver found is none.
    """
    gains, corners = loops.A.shape[:2]
    P, gamma = cp.Variable((6, 6), symmetric=True), cp.Variable(gains)
    held = [P >> 1e-6 * np.eye(6)]
    for i in range(gains):
        for j in range(corners):
            held.append(
                _gain(P, loops.A[i, j], loops.D, loops.C[j], gamma[i]) << -1e-6 * np.eye(10)
            )
    _solve(cp.Problem(cp.Minimize(total(gamma)), held))
    if P.value is None or gamma.value is None:
        raise NoController("state feedback: no quadratic function bears all gains and faults")
    limits = SLACK * np.asarray(gamma.value)
    t = cp.Variable()
    held = [P >> t * np.eye(6)]
    for i in range(gains):
        for j in range(corners):
            held.append(_gain(P, loops.A[i, j], loops.D, loops.C[j], limits[i]) << -t * np.eye(10))
    _solve(cp.Problem(cp.Maximize(t), held))
    if P.value is None:
        raise NoController("state feedback: no margin beside the least gammas")
    whole = np.asarray(P.value)
    proof = StateProof(
        0.5 * (whole + whole.T), common(loops, sample), tuple(float(g) for g in limits)
    )
    if why := failed(loops, proof, sample):
        raise NoController(f"state feedback: {why}")
    return proof


def _gain(
    P: cp.Variable, A: Array, D: Array, C: Array, gamma: cp.Expression | float
) -> cp.Expression:
    """The bounded real matrix (10, 10)."""
    entry, zero = P @ D[:, None], np.zeros((1, 3))
    rows = [
        [P @ A + A.T @ P, entry, C.T],
        [entry.T, -gamma * np.eye(1), zero],
        [C, zero.T, -gamma * np.eye(3)],
    ]
    return cast(cp.Expression, bmat(rows))  # type: ignore[no-untyped-call]


def common(loops: Loops, sample: float) -> Array:
    """P (6, 6) that falls along every loop of samples so long [s]; raises `NoController` where none is found."""
    steps = sampled(loops, sample)
    P, t = cp.Variable((6, 6), symmetric=True), cp.Variable()
    held = [P - A.T @ P @ A >> t * np.eye(6) for row in steps for A in row]
    _solve(cp.Problem(cp.Maximize(t), [*held, P << np.eye(6), P >> 1e-5 * np.eye(6)]))
    if P.value is None or t.value is None or not t.value.item() > 0.0:
        raise NoController("state feedback: no quadratic function falls along all sampled loops")
    whole = np.asarray(P.value)
    return np.asarray(0.5 * (whole + whole.T))


def _solve(problem: cp.Problem) -> None:
    """Ask the solver; what it finds is proved elsewhere."""
    try:
        problem.solve(solver=cp.CLARABEL)  # type: ignore[no-untyped-call]
    except cp.SolverError:
        return
