r"""Polytopic H-infinity output feedback, each vertex with its own gamma.

With X, Y shared by the vertices i, M N^T = I - X Y and D_c = 0, the inequality (6.25) at every vertex,

.. math::

    \begin{bmatrix}
    A X + B_2 \tilde C + * & * & * & * \\
    \tilde A + A^T & Y A + \tilde B C_2 + * & * & * \\
    B_1^T & B_1^T Y + D_{21}^T \tilde B^T & -\gamma_i I & * \\
    C_1 X + D_{12} \tilde C & C_1 & 0 & -\gamma_i I
    \end{bmatrix} < 0, \quad \begin{bmatrix} X & I \\ I & Y \end{bmatrix} > 0

and the poles in a disc, ``[-R Z, S; S', -R Z] < 0``. A Lyapunov function of rho has X = X_0 + rho X_1: only the
outputs depend on rho, so Y need not, and with it the controller does not need the rate of rho. Its inequality
is quadratic in rho; the three Bernstein coefficients are asked for, with the rate on either side.

Source: thesis (6.25)-(6.26); Scherer, Gahinet and Chilali 1997; Apkarian and Adams 1998.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import cast

import cvxpy as cp
import numpy as np
from cvxpy.atoms.affine.bmat import bmat
from er_models.model import Array

from er_ftc_controller.synthesis.certificate import growth_between, peak_gain, sampled_loop
from er_ftc_controller.synthesis.jumps import common
from er_ftc_controller.synthesis.solution import NoController, Solution, Vertex
from er_ftc_controller.synthesis.weights import Plant

STRICT = 1e-7
"""Margin of every inequality, scaled: far above the solver's accuracy, far below what it costs."""
APART = 1.0005
"""Least t in [X, t I; t I, Y] > 0: I - X Y stays away from singular."""
ATTEMPTS: tuple[dict[str, object], ...] = (
    {},
    {"max_step_fraction": 0.9},
    {"equilibrate_enable": False},
)
"""Settings of the solver, tried in turn where it fails: which gets through may hang on the last digits."""


@dataclass(frozen=True)
class Wish:
    """Radius of the disc of poles [1/s]; gamma of the greatest rho over that of the passive car; slack of the first."""

    radius: float = 250.0
    held_back: float = 1.3
    slack: float = 1.03


@dataclass(frozen=True, eq=False)
class _Unknowns:
    """Variables: X (one, or two of a straight line in rho), Y, and A, B, C at the vertices; gammas; t."""

    X: list[cp.Variable]
    Y: cp.Variable
    A: list[cp.Variable]
    B: list[cp.Variable]
    C: list[cp.Variable]
    gamma: list[cp.Expression]
    t: cp.Variable
    margin: cp.Variable
    rhos: tuple[float, ...]

    def storage(self, i: int) -> cp.Expression:
        """X at a vertex."""
        if len(self.X) == 1:
            return cast(cp.Expression, self.X[0])
        share = (self.rhos[i] - self.rhos[0]) / (self.rhos[-1] - self.rhos[0])
        return cast(cp.Expression, self.X[0] + share * self.X[1])


def smallest(
    plant: Plant,
    rhos: tuple[float, ...],
    radius: float,
    limit: float | None = None,
    rate: float | None = None,
) -> float:
    """Least gamma at the first of one or two vertices; infinite where the solver finds none.

    limit: of gamma at the second. rate: fastest change of rho [1/s] that a Lyapunov function of rho must bear;
    None: one function for all rho.
    """
    v, held = _posed(plant, rhos, radius, limit, rate)
    status = _run(cp.Problem(cp.Minimize(v.gamma[0]), [*held, v.t == APART, v.margin == STRICT]))
    value = v.gamma[0].value
    return float(value) if value is not None and "infeasible" not in status else float("inf")


def solve(plant: Plant, wish: Wish) -> Solution:
    """Controller for both ends of rho: least gamma at the lowest while that at the highest stays near the passive.

    Then, with that gamma given `slack` more, X and Y as far apart as can be, which makes the reconstruction sound;
    at last, half as far apart, the widest margins, which survive rounding.

    Raises `NoController` where the solver finds none, or none that bears the sample time and jumps of rho.
    """
    rhos = plant.weights.rho
    limit = wish.held_back * passive_gamma(plant)
    v, held = _posed(plant, rhos, wish.radius, limit, None)
    status = _run(cp.Problem(cp.Minimize(v.gamma[0]), [*held, v.t == APART, v.margin == STRICT]))
    if v.gamma[0].value is None or "optimal" not in status:
        raise NoController(f"LPV controller: {_obstacle(plant, wish, status)}")
    optimum = float(v.gamma[0].value)
    held.append(v.gamma[0] == wish.slack * optimum)
    _run(cp.Problem(cp.Maximize(v.t), [*held, v.margin == STRICT]))
    apart = APART if v.t.value is None else 0.5 * (1.0 + float(v.t.value))
    status = _run(cp.Problem(cp.Maximize(v.margin), [*held, v.t == apart]))
    if v.margin.value is None or not float(v.margin.value) > 0.0:
        raise NoController(
            f"LPV controller: no margin at gamma {wish.slack * optimum:.4g} ({status})"
        )
    vertices, P = _reconstructed(plant, v, (wish.slack * optimum, limit))
    return Solution(vertices, P, _sampled(plant, vertices, wish), optimum, status)


def _obstacle(plant: Plant, wish: Wish, status: str) -> str:
    """Why there is no controller: what one end of rho, alone, can have at best."""
    first, last = plant.weights.rho
    least = smallest(plant, (last,), wish.radius) / passive_gamma(plant)
    asked = f"poles within --radius {wish.radius:g} 1/s"
    if not np.isfinite(least):
        return f"the solver finds none with {asked}, not even for rho = {last:g} alone ({status})"
    if least > wish.held_back:
        allowed = f"--held-back allows {wish.held_back:g}"
        return f"at rho = {last:g}, with {asked}, gamma is {least:.4g} of the passive car's at least; {allowed}"
    return (
        f"the solver finds none for rho from {first:g} to {last:g} with {asked} and --held-back {wish.held_back:g} "
        f"({least:.4g} is possible at rho = {last:g} alone): allow more of one of them ({status})"
    )


def _sampled(plant: Plant, vertices: tuple[Vertex, ...], wish: Wish) -> Array:
    """One quadratic function that falls along the sampled loops of all vertices (4 + n, 4 + n)."""
    loops = [sampled_loop(plant, k) for k in vertices]
    grows = growth_between(loops)
    help_ = f"a smaller --radius than {wish.radius:g} 1/s or a narrower --rho may help"
    if not grows < 1.0:
        raise NoController(
            f"LPV controller: the sampled loop grows by {grows:.6f} per sample; {help_}"
        )
    P = common(loops)
    if P is None:
        raise NoController(
            f"LPV controller: no function found that bears jumps of rho between samples; {help_}"
        )
    return P


def passive_gamma(plant: Plant) -> float:
    """Gamma of the car without control: the largest singular value over frequency, by its weights."""
    return peak_gain(plant.A, plant.B1, plant.outputs(0.0)[0], plant.rate)


def _posed(
    plant: Plant, rhos: tuple[float, ...], radius: float, limit: float | None, rate: float | None
) -> tuple[_Unknowns, list[cp.Constraint]]:
    """Variables and inequalities."""
    n = plant.n
    gammas: list[cp.Expression] = [cp.Variable() for _ in rhos]
    if limit is not None:
        gammas[-1] = cp.Constant(limit)
    v = _Unknowns(
        [cp.Variable((n, n), symmetric=True) for _ in range(1 if rate is None else 2)],
        cp.Variable((n, n), symmetric=True),
        [cp.Variable((n, n)) for _ in rhos], [cp.Variable((n, 1)) for _ in rhos],
        [cp.Variable((1, n)) for _ in rhos], gammas, cp.Variable(), cp.Variable(), rhos,
    )  # fmt: skip
    matrices = []
    for drift in (0.0,) if rate is None else (rate, -rate):
        for i in range(len(rhos)):
            matrices += [_gain(plant, v, i, i, drift), _disc(plant, v, i, radius)]
        if rate is not None:
            matrices.append(0.5 * (_gain(plant, v, 0, 1, drift) + _gain(plant, v, 1, 0, drift)))
    unit = np.eye(n)
    held = [each << -v.margin * np.eye(each.shape[0]) for each in matrices]
    held += [
        _blocks([[v.storage(i), v.t * unit], [v.t * unit, v.Y]]) >> 0 for i in range(len(rhos))
    ]
    return v, held


def _gain(plant: Plant, v: _Unknowns, i: int, j: int, drift: float) -> cp.Expression:
    """The matrix (6.25) with the variables of vertex i and the outputs of vertex j."""
    A, B1, B2, C2 = plant.A, plant.B1, plant.B2, plant.C2
    C1, D12 = plant.outputs(v.rhos[j])
    X, Y, gamma = v.storage(i), v.Y, v.gamma[i]
    first = A @ X + B2 @ v.C[i]
    change = 0.0 * X
    if drift:
        change = drift / plant.rate / (v.rhos[-1] - v.rhos[0]) * v.X[1]
    second, mixed = Y @ A + v.B[i] @ C2, v.A[i] + A.T
    wanted = C1 @ X + D12 @ v.C[i]
    entry, zero = Y @ B1 + v.B[i] @ plant.D21, np.zeros((C1.shape[0], B1.shape[1]))
    return _blocks([
        [first + first.T - change, mixed.T, B1, wanted.T],
        [mixed, second + second.T, entry, C1.T],
        [B1.T, entry.T, -gamma * np.eye(B1.shape[1]), zero.T],
        [wanted, C1, zero, -gamma * np.eye(C1.shape[0])],
    ])  # fmt: skip


def _disc(plant: Plant, v: _Unknowns, i: int, radius: float) -> cp.Expression:
    """The matrix of the disc of poles."""
    X, unit, R = v.storage(i), np.eye(plant.n), radius / plant.rate
    S = _blocks(
        [[plant.A @ X + plant.B2 @ v.C[i], plant.A], [v.A[i], v.Y @ plant.A + v.B[i] @ plant.C2]]
    )
    Z = _blocks([[X, unit], [unit, v.Y]])
    return _blocks([[-R * Z, S], [S.T, -R * Z]])


def _reconstructed(
    plant: Plant, v: _Unknowns, gammas: tuple[float, ...]
) -> tuple[tuple[Vertex, ...], Array]:
    """Controllers and P by (6.26) with N = -Y, M = X - Y^-1, and P = [Y, -Y; -Y, Y + (X - Y^-1)^-1].

    No factor of I - X Y is taken: M is symmetric and positive definite, and solved with.
    """
    X, Y = np.asarray(v.storage(0).value), np.asarray(v.Y.value)
    M = X - np.linalg.inv(Y)
    M = 0.5 * (M + M.T)
    vertices = []
    for i, rho in enumerate(v.rhos):
        At, Bt, Ct = (np.asarray(part[i].value) for part in (v.A, v.B, v.C))
        B = -np.linalg.solve(Y, Bt)
        C = np.linalg.solve(M, Ct.T).T
        rest = At - Y @ plant.A @ X + Y @ B @ plant.C2 @ X - Y @ plant.B2 @ Ct
        A = -np.linalg.solve(M, np.linalg.solve(Y, rest).T).T
        vertices.append(Vertex(rho, A, B, C, gammas[i]))
    corner = Y + np.linalg.inv(M)
    P = np.block([[Y, -Y], [-Y, 0.5 * (corner + corner.T)]])
    return tuple(vertices), 0.5 * (P + P.T)


def _run(problem: cp.Problem) -> str:
    """Solve and return the solver's word, which is no proof: the first that is an answer, else the first."""
    said = []
    for options in ATTEMPTS:
        said.append(_once(problem, options))
        if "failed" not in said[-1]:
            return said[-1]
    return said[0]


def _once(problem: cp.Problem, options: dict[str, object]) -> str:
    """Solve with these settings; the matrices are small and full, and not taken apart."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Solution may be inaccurate")
        try:
            problem.solve(solver=cp.CLARABEL, chordal_decomposition_enable=False, **options)  # type: ignore[no-untyped-call]
        except cp.SolverError as error:
            return f"failed: {str(error).split('.')[0]}"
    return str(problem.status)


def _blocks(rows: list[list[object]]) -> cp.Expression:
    """Matrix of blocks."""
    return cast(cp.Expression, bmat(rows))  # type: ignore[no-untyped-call]
