r"""NLPV gridding observer: a Lyapunov function of the duty, gains on a grid of duties.

Theorem 4.3.2. With ``P(rho) = P_0 + rho P_1`` and ``|rho'| <= nu`` the observer of Theorem 4.3.1 has the
same properties if the inequalities of `lmi` hold for both signs of nu P_1 at every duty. The (1, 3)
and (3, 1) blocks of (4.26) are to be transposes of each other. They are asked for at the grid (4.47)
with one Y for all duties, so that ``L(rho_k) = P(rho_k)^{-1} Y`` is scheduled by P alone. It needs no
least-squares fit (4.44), which costs gamma (`fitted`), and goes straight from one grid point to the next. A Y of
its own at each point lowers gamma by less than 1e-3 and leaves gains that jump from point to point, with twice the
errors on rough roads. What the grid leaves open is closed afterwards: `proof` shows the inequalities for every duty
between, not on a finer grid.

The duty of a rig is held for a sample and then jumps, which no bound of its rate describes. So a
common Lyapunov function is sought for the same gains; without one they are refused.

Source: thesis Theorem 4.3.2, (4.37)-(4.48).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from er_models.constants import SAMPLE_TIME
from er_models.linear import LinearForm
from er_models.model import Array

from er_observers.law import Law, luenberger
from er_observers.scaling import Scaling
from er_observers.synthesis import lmi
from er_observers.synthesis.family import balanced_family
from er_observers.synthesis.proof import Claim, gaps
from er_observers.synthesis.spec import Output, Solution, Spec

THEOREM = "nlpv_gridding (Theorem 4.3.2)"
POINTS = 11
"""Points of the grid (4.47)."""
_ROUNDS = 6
RATE = 1.0 / SAMPLE_TIME
"""Fastest change of the duty [1/s]: its whole range in a sample of 5 ms, section 4.4.1."""


def claim(
    form: LinearForm,
    output: Output,
    spec: Spec,
    scaling: Scaling,
    points: int = POINTS,
    degree: int | None = 0,
) -> Claim:
    """Gains with both Lyapunov functions: of the duty, and common to all duties; raises as `solve`.

    Where the inequalities hold at two grid points and not between them, Y becomes the same for all duties and the
    middle joins the grid.
    """
    asked = problem(form, output, spec, scaling, points=points, degree=degree)
    for _ in range(_ROUNDS):
        found = lmi.solve(asked)
        claimed = Claim(form, output, spec, scaling, found)
        between = gaps(claimed)
        if not between:
            break
        asked = replace(asked, nodes=np.unique([*asked.nodes, *between]), degree=0)
    return replace(claimed, common=common(asked, found))


def solve(
    form: LinearForm,
    output: Output,
    spec: Spec,
    scaling: Scaling,
    rate: float = RATE,
    points: int = POINTS,
    degree: int | None = 0,
) -> Solution:
    """Gains on the grid and P(rho); raises `SynthesisFailed` naming what makes it impossible."""
    return lmi.solve(problem(form, output, spec, scaling, rate, points, degree))


def problem(
    form: LinearForm,
    output: Output,
    spec: Spec,
    scaling: Scaling,
    rate: float = RATE,
    points: int = POINTS,
    degree: int | None = 0,
) -> lmi.Problem:
    """The theorem's inequalities on a grid; degree: of Y in the duty, None: free at each point."""
    nodes = np.linspace(*spec.rho, points)
    return lmi.Problem(
        THEOREM, form, output, spec, scaling, balanced_family, nodes, degree=degree, rate=rate
    )


def common(claimed: lmi.Problem, solution: Solution) -> Solution:
    """One Lyapunov function for all duties and the same gains, for duties that jump."""
    return lmi.analyse(replace(claimed, rate=None), solution.law)


def fitted(form: LinearForm, solution: Solution) -> tuple[Array, Array]:
    """L_0 and L_1 (n, m) of (4.38) by the least squares (4.43)-(4.44), for comparison.

    Y(rho) = -P(rho) L(rho) is first brought to the quadratic (4.39) through the grid points.
    """
    s, rho = solution, solution.law.rho
    Y = np.array([-s.storage(float(r)) @ L for r, L in zip(rho, s.L, strict=True)])
    flat = Y.reshape(len(rho), -1)
    Y_0, Y_1, Y_2 = np.polynomial.polynomial.polyfit(rho, flat, 2).reshape(3, *Y.shape[1:])
    nothing = np.zeros_like(s.P)
    left = np.block([[s.P, nothing], [s.P_1, s.P], [nothing, s.P_1]])
    size = np.concatenate([1.0 / np.sqrt(np.diag(s.P))] * 3)
    rows = left * size[:, None]
    L = -np.linalg.pinv(rows) @ (np.vstack([Y_0, Y_1, Y_2]) * size[:, None])
    return L[: form.n], L[form.n :]


def straight(form: LinearForm, L_0: Array, L_1: Array, rho: Array) -> Law:
    """The law (4.48) at duties rho (K,)."""
    return luenberger(form, rho, np.array([L_0 + r * L_1 for r in rho]))
