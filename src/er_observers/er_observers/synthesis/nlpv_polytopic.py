r"""NLPV polytopic observer: one Lyapunov function for every duty, gains at both ends of its range.

Theorem 4.3.1, with the sector q of the gate as a parameter. For the system
``x' = A x + B rho Phi(x) + D1 w, y = C x + n`` the observer

    x^' = A x^ + B rho Phi(x^) + L(rho) (y - C x^)

has a stable error for every rho(t) in [rho_1, rho_2], and an L2 gain below gamma from the weighted
(w, n) to H e, if there are P > 0, Y_i and l_i > 0 with

.. math::

    \begin{bmatrix}
    S_i + S_i^T + H^T H + l_i q_{ss} \Gamma^T \Gamma
      & P B \rho_i + l_i q_{sd} \Gamma^T & P W + Y_i N \\
    * & l_i q_{dd} & 0 \\
    * & * & -\gamma^2 I
    \end{bmatrix} < 0, \qquad S_i = P A + Y_i C

at both ends; then L_i = -P^{-1} Y_i, and L(rho) goes straight from L_1 to L_2. Each inequality is
affine in rho, so the ends are enough, even with a multiplier l_i of their own. With q = (1, 0,
-1), the Lipschitz bound, this is (4.12) as printed; with q = (0, 1, -2), the slope restriction, it
has solutions where (4.12) has none. Poles are kept inside a disc by ``[-R P, S_i; S_i', -R P] <
0``.

Source: thesis Theorem 4.3.1; Apkarian, Gahinet and Becker 1995; disc: Chilali and Gahinet 1996.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import cast

import cvxpy as cp
import numpy as np
from cvxpy.atoms.affine.bmat import bmat
from er_models.linear import LinearForm
from er_models.model import Array

from er_observers.synthesis.necessary import violated
from er_observers.synthesis.scaling import Scaling
from er_observers.synthesis.spec import Output, Solution, Spec, SynthesisFailed

THEOREM = "nlpv_polytopic (Theorem 4.3.1)"
SOLVER = cp.CLARABEL
_DIGITS = 12
_NO_SOLUTION = (
    "no necessary condition known here is broken, but the solver found no solution: "
    "what is asked is too tight or too badly conditioned"
)


@dataclass(frozen=True, eq=False)
class _Scaled:
    """The problem in scaled states, outputs, time and gate."""

    A: Array
    B: Array
    C: Array
    Gamma: Array
    H: Array
    W: Array
    N: Array
    radius: float
    gate: float


@dataclass(frozen=True, eq=False)
class _Unknowns:
    """Variables of the theorem, and the margin t that the second solution widens."""

    P: cp.Variable
    Y: list[cp.Variable]
    multipliers: list[cp.Variable]
    gamma_2: cp.Variable
    t: cp.Variable


def solve(form: LinearForm, output: Output, spec: Spec, scaling: Scaling) -> Solution:
    """Gains and Lyapunov function; raises `SynthesisFailed` naming what makes it impossible.

    Solved twice: for the smallest gamma, then with gamma held `spec.slack` above it for the widest
    margins, which is what makes the result survive rounding and un-scaling.
    """
    reasons = violated(form, output, spec)
    if reasons:
        raise SynthesisFailed(THEOREM, "; ".join(reasons))
    scaled = _scale(form, output, spec, scaling)
    v = _unknowns(form, spec)
    constraints = _constraints(scaled, v, spec)
    status = _run(cp.Problem(cp.Minimize(v.gamma_2), [*constraints, v.t == 0.0]))
    optimum = _root(v.gamma_2, status)
    gamma = optimum * spec.slack
    if gamma > spec.gamma_max:
        reason = f"gamma {gamma:.4g} is above the {spec.gamma_max:.4g} asked for"
        raise SynthesisFailed(THEOREM, reason, status)
    status = _run(cp.Problem(cp.Maximize(v.t), [*constraints, v.gamma_2 == gamma**2]))
    if v.t.value is None or not float(v.t.value) > 0.0:
        reason = f"the inequalities leave no margin at gamma {gamma:.4g}"
        raise SynthesisFailed(THEOREM, reason, status)
    return _unscale(scaled, v, scaling, (gamma, optimum, status))


def _scale(form: LinearForm, output: Output, spec: Spec, scaling: Scaling) -> _Scaled:
    """Divide everything by its typical size."""
    x, y, rate = scaling.state, scaling.output, scaling.rate
    gamma = form.Gamma * x
    gate = float(np.linalg.norm(gamma))
    return _Scaled(
        A=form.A * x / x[:, None] / rate,
        B=(form.B / x / rate * gate)[:, None],
        C=form.C * x / y[:, None],
        Gamma=(gamma / gate)[None, :],
        H=output.rows * x,
        W=spec.input_matrix(form) / x[:, None] / rate,
        N=spec.noise_matrix() / y[:, None],
        radius=spec.radius / rate,
        gate=gate,
    )


def _unknowns(form: LinearForm, spec: Spec) -> _Unknowns:
    """Variables for one P and one gain per end of the range."""
    ends, outputs = range(len(spec.rho)), len(spec.noise)
    return _Unknowns(
        P=cp.Variable((form.n, form.n), symmetric=True),
        Y=[cp.Variable((form.n, outputs)) for _ in ends],
        multipliers=[cp.Variable((1, 1)) for _ in ends],
        gamma_2=cp.Variable(),
        t=cp.Variable(),
    )


def _constraints(s: _Scaled, v: _Unknowns, spec: Spec) -> list[cp.Constraint]:
    """The inequalities of the theorem at each end of the range, with margin t."""
    n, inputs = s.A.shape[0], s.W.shape[1]
    (q_ss, q_sd), (_, q_dd) = spec.sector.form
    gap = np.zeros((1, inputs))
    constraints = [v.P >> v.t * np.eye(n)]
    for rho, Y, m in zip(spec.rho, v.Y, v.multipliers, strict=True):
        S = v.P @ s.A + Y @ s.C
        corner = S + S.T + s.H.T @ s.H + s.Gamma.T @ (m * q_ss) @ s.Gamma
        gate = v.P @ s.B * rho + s.Gamma.T @ m * q_sd
        noise = v.P @ s.W + Y @ s.N
        whole = _blocks([
            [corner, gate, noise],
            [gate.T, m * q_dd, gap],
            [noise.T, gap.T, -v.gamma_2 * np.eye(inputs)],
        ])  # fmt: skip
        disc = _blocks([[-s.radius * v.P, S], [S.T, -s.radius * v.P]])
        constraints += [
            whole << -v.t * np.eye(n + 1 + inputs),
            disc << -v.t * np.eye(2 * n),
            m >= v.t,
        ]
    return constraints


def _blocks(rows: list[list[object]]) -> cp.Expression:
    """Matrix of blocks."""
    return cast(cp.Expression, bmat(rows))  # type: ignore[no-untyped-call]


def _run(problem: cp.Problem) -> str:
    """Solve and return the solver's word, which is not taken for a proof."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Solution may be inaccurate")
        try:
            problem.solve(solver=SOLVER)  # type: ignore[no-untyped-call]
        except cp.SolverError as error:
            return f"failed: {str(error).split('.')[0]}"
    return str(problem.status)


def _root(gamma_2: cp.Variable, status: str) -> float:
    """Optimum of gamma, or `SynthesisFailed`."""
    if "infeasible" in status or gamma_2.value is None or not float(gamma_2.value) > 0.0:
        raise SynthesisFailed(THEOREM, _NO_SOLUTION, status)
    return float(np.sqrt(gamma_2.value))


def _unscale(
    s: _Scaled, v: _Unknowns, scaling: Scaling, found: tuple[float, float, str]
) -> Solution:
    """Back to SI units, rounded to what will be written: what is proved is what is used."""
    x, y, rate = scaling.state, scaling.output, scaling.rate
    P = np.asarray(v.P.value)
    L = [-np.linalg.solve(P, np.asarray(Y.value)) * x[:, None] / y * rate for Y in v.Y]
    gamma, optimum, status = found
    return Solution(
        L=_round(np.array(L)),
        P=_round(0.5 * (P + P.T) / x / x[:, None] / rate),
        multipliers=_round(np.ravel([m.value for m in v.multipliers]) / s.gate**2),
        gamma=float(f"{gamma:.8g}"),
        optimum=float(f"{optimum:.6g}"),
        solver_status=status,
    )


def _round(values: Array) -> Array:
    """Twelve significant digits."""
    return np.array([float(f"{v:.{_DIGITS}g}") for v in np.ravel(values)]).reshape(values.shape)
