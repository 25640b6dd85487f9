"""One quadratic function for several sampled loops: what bears jumps of the scheduling parameter."""

from __future__ import annotations

import cvxpy as cp
import numpy as np
from er_models.model import Array
from scipy.linalg import solve_discrete_lyapunov


def common(loops: list[Array]) -> Array | None:
    """P (n, n) with P - A' P A > 0 for every A (n, n), as the solver finds it; None where it finds none.

    Looked for in the coordinates in which that of the first loop alone is the unit matrix.
    """
    n = loops[0].shape[0]
    own = np.linalg.cholesky(solve_discrete_lyapunov(loops[0].T, np.eye(n))).T
    back = np.linalg.inv(own)
    P, t = cp.Variable((n, n), symmetric=True), cp.Variable()
    turned = [own @ A @ back for A in loops]
    held = [P - A.T @ P @ A >> t * np.eye(n) for A in turned]
    problem = cp.Problem(cp.Maximize(t), [*held, P << np.eye(n), P >> t * np.eye(n)])
    try:
        problem.solve(solver=cp.CLARABEL)  # type: ignore[no-untyped-call]
    except cp.SolverError:
        return None
    if P.value is None or t.value is None or not t.value.item() > 0.0:
        return None
    whole = own.T @ np.asarray(P.value) @ own
    return np.asarray(0.5 * (whole + whole.T))
