r"""The linear matrix inequalities that all theorems share, and their solution.

For an observer of a `Family` the error obeys

.. math::  \zeta' = (A_{11} - Z A_{12}) \zeta + T B \rho\, d + W w, \quad
           s = G \zeta + G_w w, \quad h = H \zeta + H_w w

and V = zeta' P(rho) zeta proves an L2 gain gamma from w to h where, with Y = P Z,
S = P A11 - Y A12 and the sector ``[s, d] q [s, d]' >= 0`` of the gate,

.. math::

    \begin{bmatrix}
    S + S^T \pm \nu P_1 + H^T H + l q_{ss} G^T G
      & P T B \rho + l q_{sd} G^T & P W + H^T H_w + l q_{ss} G^T G_w \\
    * & l q_{dd} & l q_{sd} G_w \\
    * & * & H_w^T H_w + l q_{ss} G_w^T G_w - \gamma^2 I
    \end{bmatrix} < 0

at every design node. Poles are kept inside a disc by ``[-R P, S; S', -R P] < 0``, left of a line by
``S + S' + 2 a P < 0`` and in a cone of damping cos(theta) by
``[sin (S + S'), cos (S - S'); *, sin (S + S')] < 0``.

Source: thesis (3.61), (4.23), (4.34) with the sector as a parameter; regions: Chilali and Gahinet 1996.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import cast

import cvxpy as cp
import numpy as np
from cvxpy.atoms.affine.trace import trace
from er_models.linear import LinearForm
from er_models.model import Array

from er_observers.law import Law
from er_observers.scaling import Scaling
from er_observers.synthesis.conditioning import reason_of_condition
from er_observers.synthesis.family import Family
from er_observers.synthesis.necessary import violated
from er_observers.synthesis.scaled import Scaled, law_of, rounded, scale, storage_of, units
from er_observers.synthesis.solver import SOLVER, blocks, run
from er_observers.synthesis.spec import Output, Solution, Spec, SynthesisFailed

Maker = Callable[[Array, Array, Array], Family]
"""A structure from scaled A, C and D1."""
NO_SOLUTION = (
    "no necessary condition known here is broken, but the solver found no solution: "
    "what is asked is too tight or too badly conditioned"
)


@dataclass(frozen=True, eq=False)
class Problem:
    """What to solve.

    family: structure, made of scaled A, C and D1. nodes (K,): duties at which the inequalities are
    asked for. degree: of Y = P Z in the duty, 0: one gain for all, None: free at each node. rate:
    fastest change of the duty [1/s] that a Lyapunov function of the duty must bear; None: one
    function for all duties.
    """

    theorem: str
    form: LinearForm
    output: Output
    spec: Spec
    scaling: Scaling
    family: Maker
    nodes: Array
    degree: int | None = None
    rate: float | None = None
    solver: str = SOLVER


@dataclass(frozen=True, eq=False)
class Unknowns:
    """Variables beside the gains.

    P: its coefficients; multipliers: at the nodes; t: the margin to widen; variances: at the nodes, with their bounds.
    """

    P: list[cp.Variable]
    multipliers: list[cp.Variable]
    gamma_2: cp.Variable
    t: cp.Variable
    variances: list[tuple[cp.Variable, cp.Constraint]]

    def storage(self, rho: float) -> cp.Expression:
        """P at a duty."""
        return self.P[0] if len(self.P) == 1 else self.P[0] + rho * self.P[1]


def solve(problem: Problem) -> Solution:
    """Gains and Lyapunov function; raises `SynthesisFailed` naming what makes it impossible.

    Solved three times, see `optimise`.
    """
    p = problem
    reasons = violated(p.form, p.output, p.spec)
    if reasons:
        raise SynthesisFailed(p.theorem, "; ".join(reasons))
    posed = _pose(p)
    try:
        found = optimise(p.theorem, p.spec, posed.v, posed.constraints, p.solver)
    except SynthesisFailed as failed:
        reason = reason_of_condition(posed.s, posed.family, p.spec)
        if failed.reason != NO_SOLUTION or not reason:
            raise
        raise SynthesisFailed(p.theorem, reason, failed.solver_status) from failed
    return _gains(p, posed, found)


def smallest(problem: Problem) -> float:
    """The optimum of gamma alone, infinite for none: one solution in the place of three."""
    posed = _pose(problem)
    held = [*posed.constraints, posed.v.t == 0.0]
    status = run(cp.Problem(cp.Minimize(posed.v.gamma_2), held), problem.solver)
    value = posed.v.gamma_2.value
    return float(np.sqrt(np.asarray(value))) if "optimal" in status else float("inf")


def widest(problem: Problem, gamma: float) -> Solution:
    """Gains of the widest margins (at most 1, scaled) for a gamma that is given.

    Raises `SynthesisFailed` where there is no margin.
    """
    p, posed = problem, _pose(problem)
    v = posed.v
    held = [*posed.constraints, v.gamma_2 == gamma**2, v.t <= 1.0]
    status = run(cp.Problem(cp.Maximize(v.t), held), p.solver, lambda: _positive(v.t))
    if not _positive(v.t):
        raise SynthesisFailed(p.theorem, f"no margin at gamma {gamma:.4g}", status)
    return _gains(p, posed, (gamma, status))


@dataclass(frozen=True, eq=False)
class _Posed:
    """A problem's inequalities: scaled, structure, variables, gains at the nodes."""

    s: Scaled
    family: Family
    v: Unknowns
    Y: list[cp.Expression]
    constraints: list[cp.Constraint]


def _pose(p: Problem) -> _Posed:
    """The inequalities at every node."""
    s = scale(p.form, p.output, p.spec, p.scaling)
    family = p.family(s.A, s.C, s.D1)
    order, q = family.A11.shape[0], family.A12.shape[0]
    v = _unknowns(p, order)
    count = len(p.nodes) if p.degree is None else p.degree + 1
    parts = [cp.Variable((order, q)) for _ in range(count)]
    Y: list[cp.Expression] = [*parts]
    if p.degree is not None:
        Y = [sum(rho**i * part for i, part in enumerate(parts)) for rho in p.nodes]
    constraints: list[cp.Constraint] = []
    for k, rho in enumerate(p.nodes):
        P = v.storage(float(rho))
        S = P @ family.A11 - Y[k] @ family.A12
        noise = P @ (family.T @ s.W) - (P @ family.B11 - Y[k] @ family.B12) @ s.N
        constraints += _node(p, s, family, v, k, S, noise)
        _bound_variance(v, P, noise)
    return _Posed(s, family, v, Y, constraints)


def _gains(p: Problem, posed: _Posed, found: tuple[float, str]) -> Solution:
    """The solver's values as gains in SI units."""
    s, family, v = posed.s, posed.family, posed.v
    Z = [
        np.linalg.solve(np.asarray(v.storage(float(rho)).value), np.asarray(gain.value))
        for rho, gain in zip(p.nodes, posed.Y, strict=True)
    ]
    return _solution(p, s, v, law_of(s, p.form, family, p.nodes, Z), units(s, family), found)


def analyse(problem: Problem, law: Law) -> Solution:
    """Lyapunov function that proves the smallest gamma for a law that is given, at its own nodes.

    The problem's family and nodes do not matter. Raises `SynthesisFailed` where there is none.
    """
    p = replace(problem, nodes=law.rho)
    s, z = scale(p.form, p.output, p.spec, p.scaling), law.sizes(p.scaling.state)
    x, y, rate = p.scaling.state, p.scaling.output, p.scaling.rate
    frame = Family(
        *(np.zeros(0),) * 4, law.T * x / z[:, None], law.R * z / x[:, None], law.S * y / x[:, None]
    )
    v = _unknowns(p, law.order)
    constraints: list[cp.Constraint] = []
    for k, rho in enumerate(law.rho):
        P = v.storage(float(rho))
        J = law.J[k] * y / z[:, None] / rate
        noise = P @ (frame.T @ s.W - J @ s.N)
        constraints += _node(p, s, frame, v, k, P @ (law.M[k] * z / z[:, None] / rate), noise)
    return _solution(p, s, v, law, z, optimise(p.theorem, p.spec, v, constraints, p.solver))


def _solution(
    p: Problem, s: Scaled, v: Unknowns, law: Law, z: Array, found: tuple[float, str]
) -> Solution:
    """Everything back in SI units; z (N,): size of one scaled unit of each observer state."""
    P = [storage_of(s, z, np.asarray(part.value)) for part in v.P]
    optimum, status = found
    return Solution(
        law=law,
        P=P[0],
        P_1=P[1] if p.rate is not None else np.zeros_like(P[0]),
        rate=p.rate or 0.0,
        multipliers=rounded(np.ravel([m.value for m in v.multipliers]) / s.gate**2),
        gamma=float(f"{np.sqrt(np.asarray(v.gamma_2.value)):.8g}"),
        optimum=float(f"{optimum:.6g}"),
        solver_status=status,
    )


def optimise(
    theorem: str, spec: Spec, v: Unknowns, constraints: list[cp.Constraint], solver: str = SOLVER
) -> tuple[float, str]:
    """Optimum of gamma, and the solver's word, which is not taken for a proof.

    First the smallest gamma, a peak that often lies at zero frequency and leaves the gain free
    elsewhere; then, with gamma held `spec.slack` above it, the smallest variance of the output for
    white inputs (`_bound_variance`); at last, with that held as well, the widest margins.
    """
    least = cp.Problem(cp.Minimize(v.gamma_2), [*constraints, v.t == 0.0])
    status = run(least, solver, lambda: _positive(v.gamma_2))
    if "infeasible" in status or not _positive(v.gamma_2):
        raise SynthesisFailed(theorem, NO_SOLUTION, status)
    optimum = float(np.sqrt(np.asarray(v.gamma_2.value)))
    gamma = optimum * spec.slack
    if gamma > spec.gamma_max:
        reason = f"gamma {gamma:.4g} is above the {spec.gamma_max:.4g} asked for"
        raise SynthesisFailed(theorem, reason, status)
    held = [*constraints, v.gamma_2 == gamma**2]
    for more in (_calmest(spec, v, held, solver), []):
        widest = cp.Problem(cp.Maximize(v.t), [*held, *more])
        status = run(widest, solver, lambda: _positive(v.t))
        if _positive(v.t):
            return optimum, status
    reason = f"the inequalities leave no margin at gamma {gamma:.4g}"
    raise SynthesisFailed(theorem, reason, status)


def _calmest(
    spec: Spec, v: Unknowns, held: list[cp.Constraint], solver: str
) -> list[cp.Constraint]:
    """Bounds of the output's variance for white inputs, at its smallest with some slack; none where none is found."""
    if not v.variances:
        return []
    total = cast(cp.Expression, sum(trace(Q) for Q, _ in v.variances))  # type: ignore[no-untyped-call]
    bounds = [c for _, c in v.variances]
    status = run(cp.Problem(cp.Minimize(total), [*held, *bounds, v.t == 0.0]), solver)
    if "optimal" not in status or total.value is None:
        return []
    return [*bounds, cast(cp.Constraint, total <= spec.slack * float(total.value))]


def _positive(unknown: cp.Variable) -> bool:
    """Whether a solver has left a value above zero."""
    return unknown.value is not None and float(unknown.value) > 0.0


def _unknowns(p: Problem, order: int) -> Unknowns:
    """Variables: P of one or two coefficients, a multiplier for each node."""
    return Unknowns(
        P=[cp.Variable((order, order), symmetric=True) for _ in range(1 + (p.rate is not None))],
        multipliers=[cp.Variable((1, 1)) for _ in p.nodes],
        gamma_2=cp.Variable(),
        t=cp.Variable(),
        variances=[],
    )


def _node(
    p: Problem,
    s: Scaled,
    frame: Family,
    v: Unknowns,
    k: int,
    S: cp.Expression,
    noise: cp.Expression,
) -> list[cp.Constraint]:
    """The inequalities at one node; S (N, N) = P M, noise (N, w) = P W."""
    P = v.storage(float(p.nodes[k]))
    step = 0.0 if p.rate is None else 0.5 * p.rate / s.scaling.rate
    drifts = [step * v.P[1], -step * v.P[1]] if p.rate is not None else [0.0 * P]
    wholes = [
        *(dissipation(p.spec, s, frame, v, k, float(p.nodes[k]), S + d, noise) for d in drifts),
        *regions(p.spec, s, P, S),
    ]
    return [
        P >> v.t * np.eye(P.shape[0]),
        v.multipliers[k] >= v.t,
        *(each << -v.t * np.eye(each.shape[0]) for each in wholes),
    ]


def _bound_variance(v: Unknowns, P: cp.Expression, noise: cp.Expression) -> None:
    """Add a bound Q of W' P W, whose trace bounds the variance of the output for white w."""
    Q = cp.Variable((noise.shape[1], noise.shape[1]), symmetric=True)
    v.variances.append((Q, blocks([[Q, noise.T], [noise, P]]) >> 0))


def dissipation(
    spec: Spec, s: Scaled, frame: Family, v: Unknowns, k: int, rho: float,
    S: cp.Expression, noise: cp.Expression,
) -> cp.Expression:  # fmt: skip
    """The matrix of the module's docstring; S (N, N) with half the drift."""
    (q_ss, q_sd), (_, q_dd) = spec.sector.form
    m, P = v.multipliers[k], v.storage(rho)
    H, H_w = s.H @ frame.R, -s.H @ frame.S @ s.N
    G, G_w = s.Gamma @ frame.R, -s.Gamma @ frame.S @ s.N
    gate = P @ (frame.T @ s.B) * rho + G.T @ m * q_sd
    entry = noise + H.T @ H_w + G.T @ (m * q_ss) @ G_w
    through = m * q_sd @ G_w
    corner = H_w.T @ H_w + G_w.T @ (m * q_ss) @ G_w - v.gamma_2 * np.eye(H_w.shape[1])
    return blocks([
        [S + S.T + H.T @ H + G.T @ (m * q_ss) @ G, gate, entry],
        [gate.T, m * q_dd, through],
        [entry.T, through.T, corner],
    ])  # fmt: skip


def regions(spec: Spec, s: Scaled, P: cp.Expression, S: cp.Expression) -> list[cp.Expression]:
    """Matrices, negative definite when the poles lie in the region asked for."""
    radius = spec.radius / s.scaling.rate
    found = [blocks([[-radius * P, S], [S.T, -radius * P]])]
    if spec.decay > 0.0:
        found.append(S + S.T + 2.0 * spec.decay / s.scaling.rate * P)
    if spec.damping > 0.0:
        sine, both, skew = np.sqrt(1.0 - spec.damping**2), S + S.T, spec.damping * (S - S.T)
        found.append(blocks([[sine * both, skew], [skew.T, sine * both]]))
    return found
