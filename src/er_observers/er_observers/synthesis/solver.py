"""The solver of the linear matrix inequalities, and how their blocks are put together."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import cast

import cvxpy as cp
from cvxpy.atoms.affine.bmat import bmat

SOLVER = cp.CLARABEL
_WHOLE: dict[str, object] = {"chordal_decomposition_enable": False}
"""The matrices are small and full; taken apart, the badly conditioned ones fail."""
ATTEMPTS: dict[str, tuple[dict[str, object], ...]] = {
    SOLVER: (
        _WHOLE,
        _WHOLE | {"direct_solve_method": "faer"},
        _WHOLE | {"max_step_fraction": 0.9},
        _WHOLE | {"equilibrate_max_iter": 50},
        _WHOLE | {"equilibrate_enable": False},
        _WHOLE | {"max_step_fraction": 0.7},
    ),
    cp.SCS: ({"eps": 1e-7, "max_iters": 20000, "acceleration_lookback": 0},),
}
"""Settings, tried in turn. Where a problem is badly conditioned the last digits decide whether a solver gets through,
and those are another processor's where its linear algebra has other kernels: what one setting solves on one of them
fails on the next, and all the same another setting solves it there."""
SURE = 2
"""Settings that must say that there is no solution before it is believed."""


def run(
    problem: cp.Problem, solver: str = SOLVER, usable: Callable[[], bool] = lambda: True
) -> str:
    """Solve and return the solver's word: that of the first settings whose solution is usable, else of the first.

    usable: whether the values that are left in the problem's variables will do.
    """
    said: list[str] = []
    for options in ATTEMPTS[solver]:
        status = _once(problem, solver, options)
        if "optimal" in status and usable():
            return status
        said.append(status)
        if sum("infeasible" in word for word in said) == SURE:
            break
    return said[0]


def _once(problem: cp.Problem, solver: str, options: dict[str, object]) -> str:
    """Solve with these settings."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Solution may be inaccurate")
        try:
            problem.solve(solver=solver, **options)  # type: ignore[no-untyped-call]
        except cp.SolverError as error:
            return f"failed: {str(error).split('.')[0]}"
    return str(problem.status)


def blocks(rows: list[list[object]]) -> cp.Expression:
    """Matrix of blocks."""
    return cast(cp.Expression, bmat(rows))  # type: ignore[no-untyped-call]
