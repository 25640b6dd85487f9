"""The solver of the linear matrix inequalities, and how their blocks are put together."""

from __future__ import annotations

import warnings
from typing import cast

import cvxpy as cp
from cvxpy.atoms.affine.bmat import bmat

SOLVER = cp.CLARABEL
OPTIONS: dict[str, dict[str, object]] = {
    SOLVER: {"chordal_decomposition_enable": False},
    cp.SCS: {"eps": 1e-7, "max_iters": 20000},
}
"""The matrices are small and full; taken apart, the badly conditioned ones fail."""


def run(problem: cp.Problem, solver: str = SOLVER) -> str:
    """Solve and return the solver's word."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Solution may be inaccurate")
        try:
            problem.solve(solver=solver, **OPTIONS.get(solver, {}))  # type: ignore[no-untyped-call]
        except cp.SolverError as error:
            return f"failed: {str(error).split('.')[0]}"
    return str(problem.status)


def blocks(rows: list[list[object]]) -> cp.Expression:
    """Matrix of blocks."""
    return cast(cp.Expression, bmat(rows))  # type: ignore[no-untyped-call]
