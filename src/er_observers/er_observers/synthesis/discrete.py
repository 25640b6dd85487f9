r"""Stability of what really runs: the error from one substep of the kernel to the next.

The kernel is exact in the linear part and takes the mean of the gate along each substep. For two
runs of it that differ by e_0 at the start, the mean value theorem gives
``d = k_0 Gamma e_0 + k_1 Gamma e_1`` with

.. math::  k_0 = \int (1 - \theta) g\, d\theta, \quad k_1 = \int \theta g\, d\theta, \quad
           0 \le g \le 1

so (k_0, k_1) lies in a lens whose edge is reached by gates that are open on one part of the
substep. Where one Lyapunov function shrinks with every such map, any two runs converge, however
the duty jumps from sample to sample. The theorem's own need not (it knows no substeps), so one is
sought for the maps themselves. Substeps of the usual length are looked up over the duty
(`observers.table`): their maps are those of the table, at its duties and in the middle between two,
where it is farthest from the law.
"""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import product
from typing import NamedTuple

import cvxpy as cp
import numpy as np
from er_models.model import Array
from scipy.linalg import expm

from er_observers.observers.kernel import SUBSTEP
from er_observers.observers.table import Table, table_of
from er_observers.synthesis.proof import Claim
from er_observers.synthesis.solver import run as run_solver
from er_observers.synthesis.spec import SynthesisFailed

_ROUNDS = 8
_SHARES = (0.8, 0.2, 0.02)
_TURNS = (1, 2, 4, 8)
"""How often one substep follows another where two in turn are looked at."""
_Point = tuple[float, float, tuple[float, float]]
"""Step length [s], duty, gate."""


class Contraction(NamedTuple):
    """Slowest decay of the Lyapunov norm over a substep [1/s], and where it is.

    Above zero any two runs converge. loop: largest gain of the gate around a substep; below 2 the
    kernel's scalar equation has one root.
    """

    decay: float
    step: float
    rho: float
    gate: tuple[float, float]
    loop: float


def lens(points: int = 25) -> Array:
    """Edge of the set of (k_0, k_1), shape (2 points, 2)."""
    a = np.linspace(0.0, 1.0, points)
    edge = np.column_stack([a - 0.5 * a**2, 0.5 * a**2])
    return np.vstack([edge, edge[:, ::-1]])


def step_storage(
    claim: Claim, steps: tuple[float, ...], slowest: float
) -> tuple[Array, Contraction]:
    """P (N, N) of a Lyapunov function that every substep shrinks, and how fast; `SynthesisFailed` without.

    One for all step lengths [s], duties and gates, with a decay of 80 % of the slowest pole [1/s],
    or less where that cannot be had: first for a coarse grid, then again with the worst point of
    the fine one of `contraction`, until that is in order.
    """
    points = [*product(steps, np.linspace(*claim.spec.rho, 3), map(tuple, lens(3)))]
    failure: SynthesisFailed | None = None
    for share in _SHARES:
        try:
            return _refine(claim, steps, points, share * abs(slowest))
        except SynthesisFailed as error:
            failure = failure or error
    why = _obstacle(claim, points)
    status = failure.solver_status if failure else "not asked"
    reason = failure.reason if failure else ""
    raise SynthesisFailed("discrete", f"{reason}: {why}", status)


def _obstacle(claim: Claim, points: list[_Point]) -> str:
    """What stands in the way, in words: two substeps that grow in turn leave no Lyapunov function to be found."""
    z = claim.sizes
    maps = np.array([_map(claim, s, float(r), np.array(g)) * z / z[:, None] for s, r, g in points])
    worst, pair = 0.0, (points[0], points[0])
    for times in _TURNS:
        turns = maps[:, None] @ np.linalg.matrix_power(maps, times)
        growth = np.abs(np.linalg.eigvals(turns)).max(axis=-1) ** (1.0 / (1 + times))
        i, j = np.unravel_index(int(np.argmax(growth)), growth.shape)
        if growth[i, j] > worst:
            worst, pair = float(growth[i, j]), (points[i], points[j])
    names = " and ".join(f"{step:g} s at duty {rho:g}" for step, rho, _ in pair)
    words = f"substeps of {names} in turn, the gate's slope changing, grow by {worst:.4g} each; "
    if worst <= 1.0:
        words = f"no two in turn grow (at most {worst:.5g} each), so the solver is the limit; "
    fastest = max(float(np.abs(np.linalg.eigvals(M)).max()) for M in claim.solution.law.M)
    longest = max(step for step, _, _ in points)
    radius = claim.spec.radius
    words += f"the fastest pole, {fastest:.4g} 1/s, is {fastest * longest:.3g} per substep; "
    return words + f"a smaller --radius may help (now {radius:g} 1/s)"


def _refine(
    claim: Claim, steps: tuple[float, ...], points: list[_Point], decay: float
) -> tuple[Array, Contraction]:
    """As `step_storage`, for one decay [1/s]."""
    points = [*points]
    for _ in range(_ROUNDS):
        P = _storage(claim, points, decay)
        run = contraction(claim, P, steps)
        if run.decay > 0.0:
            break
        points.append((run.step, run.rho, run.gate))
    return P, run


def _storage(claim: Claim, points: list[_Point], decay: float) -> Array:
    """P that shrinks with the maps at these points."""
    z = claim.sizes
    P, t = cp.Variable((len(z), len(z)), symmetric=True), cp.Variable()
    constraints = [P >> np.eye(len(z)), t <= 1.0]
    for step, rho, gate in points:
        moved = _map(claim, step, float(rho), np.array(gate)) * z / z[:, None]
        left = np.exp(-2.0 * decay * step) * P - moved.T @ P @ moved
        constraints.append(left >> t * np.eye(len(z)))
    status = run_solver(cp.Problem(cp.Maximize(t), constraints))
    if t.value is None or not float(t.value) > 0.0:
        longest = max(step for step, _, _ in points)
        reason = f"no Lyapunov function shrinks with every substep of {longest:g} s"
        raise SynthesisFailed("discrete", reason, status)
    return np.asarray(P.value) / z / z[:, None]


def contraction(claim: Claim, P: Array, steps: tuple[float, ...], duties: int = 21) -> Contraction:
    """Slowest decay of ``sqrt(e' P e)`` over step lengths [s], duties and the lens."""
    law, e = claim.solution.law, claim.error
    root = np.linalg.cholesky(P).T
    back = np.linalg.inv(root)
    worst, loop = Contraction(float("inf"), 0.0, 0.0, (0.0, 0.0), 0.0), -float("inf")
    edge = lens()
    rows = looked_up(claim).duties
    grid = [*np.linspace(law.rho[0], law.rho[-1], duties), *law.rho]
    for step in steps:
        more = [*rows, *(0.5 * (rows[1:] + rows[:-1]))] if math.isclose(step, SUBSTEP) else []
        for rho in np.unique([*grid, *more]):
            linear, kick = _moved(claim, step, float(rho))
            loop = max(loop, float(e.G[0] @ kick))
            maps = error_map(linear, kick, e.G[0], edge)
            growth = np.linalg.norm(root @ maps @ back, 2, axis=(1, 2))
            at = int(np.argmax(growth))
            decay = float(-np.log(growth[at]) / step)
            if decay < worst.decay:
                gate = (float(edge[at, 0]), float(edge[at, 1]))
                worst = Contraction(decay, step, float(rho), gate, 0.0)
    return worst._replace(loop=loop)


@lru_cache(maxsize=4)
def looked_up(claim: Claim) -> Table:
    """The substeps that the observer of a claim looks up."""
    law = claim.solution.law
    return table_of(law, claim.error.b[:, 0], claim.sizes, claim.scaling.output)


def _moved(claim: Claim, step: float, rho: float) -> tuple[Array, Array]:
    """Linear map (N, N) of a substep [s] and the effect (N,) of the gate held at one, as they run [SI]."""
    if not math.isclose(step, SUBSTEP):
        return substep(claim.solution.law.at(rho)[0], claim.error.b[:, 0] * rho, step)
    row, z = looked_up(claim).at(rho), claim.sizes
    return row[:, : z.size] * z[:, None] / z, rho * row[:, -1] * z


def _map(claim: Claim, step: float, rho: float, gate: Array) -> Array:
    """Map (N, N) of the difference of two runs over one substep [s]."""
    linear, kick = _moved(claim, step, rho)
    return error_map(linear, kick, claim.error.G[0], gate)


def substep(M: Array, b: Array, step: float) -> tuple[Array, Array]:
    """Exact linear map (N, N) of one substep [s] and the effect (N,) of the gate held at one."""
    n = M.shape[0]
    whole = np.zeros((n + 1, n + 1))
    whole[:-1, :-1], whole[:-1, -1] = M, b
    moved = expm(whole * step)
    return moved[:-1, :-1], moved[:-1, -1]


def error_map(linear: Array, kick: Array, gamma: Array, gate: Array) -> Array:
    """Maps (..., N, N) of the difference of two runs over one substep, for (k_0, k_1) = gate (..., 2)."""
    loop, k = np.outer(kick, gamma), gate[..., None, None]
    left = np.eye(len(kick)) - k[..., 1, :, :] * loop
    return np.asarray(np.linalg.solve(left, linear + k[..., 0, :, :] * loop), np.float64)
