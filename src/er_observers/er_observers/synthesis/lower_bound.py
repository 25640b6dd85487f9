r"""A gamma that no gain can go below, proved in fractions: the other half of what a second solver would say.

The inequalities of `lmi` are affine, ``F_j(v) = F_j0 + sum_i v_i F_ji <= 0``, in v = (gamma^2, P, Y, multipliers).
For any ``Z_j > 0`` with ``sum_j <Z_j, F_ji> = 0`` for every variable but gamma^2, and -1 for that one, all feasible
v have

.. math::  \gamma^2 \ge \gamma^2 + \sum_j \langle Z_j, F_j(v) \rangle = \sum_j \langle Z_j, F_{j0} \rangle

A solver proposes Z, a little inside the cone; an exact projection then makes the equations hold, and what it moves is
less than how far Z was inside, shown in fractions as well. Nothing is taken from the solver but the proposal. Of the
regions of the poles only the disc is asked for and of a Lyapunov function of the duty one duty, which may lower the
bound but not spoil it: the mean of both signs of the rate is the inequality without it. For the
unified observer the solver finds no Z inside the cone, so there is no bound.

Source: weak duality, Vandenberghe and Boyd 1996; rounding to a proof: Jansson, Chaykin and Keil 2007.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import NamedTuple, cast

import cvxpy as cp
import numpy as np
from cvxpy.atoms.affine.trace import trace
from er_models.exact import Exact, exact, is_positive_definite, solved
from er_models.model import Array

from er_observers.synthesis.family import Family
from er_observers.synthesis.lmi import Problem
from er_observers.synthesis.proof import dissipation
from er_observers.synthesis.scaled import Scaled, scale
from er_observers.synthesis.solver import run
from er_observers.synthesis.spec import Spec, SynthesisFailed

SLACK = 0.01
"""Share of the bound that is given away to be inside the cone."""


class _Point(NamedTuple):
    """Values of all unknowns: gamma^2, P (N, N), Y (K, N, q), multipliers (K,)."""

    gamma_2: Fraction
    P: Exact
    Y: Exact
    multipliers: Exact


def lower_bound(problem: Problem) -> float:
    """Gamma (rounded down to 6 digits) below which the inequalities have no solution, proved exactly.

    Raises `SynthesisFailed` where no proof was found.
    """
    nodes = problem.nodes if problem.rate is None else problem.nodes[-1:]
    s = scale(problem.form, problem.output, problem.spec, problem.scaling)
    family = problem.family(s.A, s.C, s.D1)
    columns = _columns(problem.spec, s, family, nodes, problem.degree == 0)
    sizes = [len(block) for block in columns[0]]
    rows = np.array([_stacked(column) for column in columns])
    proposed = _proposal(rows.astype(float), sizes)
    if proposed is None:
        raise SynthesisFailed(
            problem.theorem, "the dual problem has no interior that a solver finds"
        )
    Z, inside = proposed
    bound = _proved(rows, Z, sizes, inside)
    if not bound > 0:
        raise SynthesisFailed(problem.theorem, "the proposed multipliers prove nothing")
    return float(np.floor(1e6 * np.sqrt(float(bound)) * (1.0 - 1e-12)) / 1e6)


def _columns(
    spec: Spec, s: Scaled, family: Family, nodes: Array, one_gain: bool
) -> list[list[Exact]]:
    """Blocks F_j0, then F_ji of each unknown, gamma^2 first."""
    points = _points(family, len(nodes), one_gain)
    first = _blocks(spec, s, family, nodes, next(points))
    return [
        first,
        *(
            [a - b for a, b in zip(_blocks(spec, s, family, nodes, point), first, strict=True)]
            for point in points
        ),
    ]


def _points(family: Family, count: int, one_gain: bool) -> Iterator[_Point]:
    """Nothing, then each unknown alone at one."""
    n, q = family.A11.shape[0], family.A12.shape[0]
    P, Y, m = exact(np.zeros((n, n))), exact(np.zeros((count, n, q))), exact(np.zeros(count))
    none, one = Fraction(0), Fraction(1)
    yield _Point(none, P, Y, m)
    yield _Point(one, P, Y, m)
    for i in range(n):
        for j in range(i + 1):
            P_i = P.copy()
            P_i[i, j] = P_i[j, i] = one
            yield _Point(none, P_i, Y, m)
    for k in [slice(None)] if one_gain else range(count):
        for i in range(n):
            for j in range(q):
                Y_i = Y.copy()
                Y_i[k, i, j] = one
                yield _Point(none, P, Y_i, m)
    for k in range(count):
        m_i = m.copy()
        m_i[k] = one
        yield _Point(none, P, Y, m_i)


def _blocks(spec: Spec, s: Scaled, family: Family, nodes: Array, v: _Point) -> list[Exact]:
    """Dissipation and disc at every node, in fractions of the scaled doubles; not the blocks of `lmi`."""
    A11, A12, B11, B12, T, R, S_y = (exact(part) for part in family)
    N, q = exact(s.N), exact(spec.sector.form)
    G, H = exact(s.Gamma) @ R, exact(s.H) @ R
    shown = (G, -exact(s.Gamma) @ S_y @ N, H, -exact(s.H) @ S_y @ N)
    TW, TB, radius = T @ exact(s.W), T @ exact(s.B), exact(spec.radius / s.scaling.rate)[()]
    found = []
    for rho, Y, m in zip(exact(nodes), v.Y, v.multipliers, strict=True):
        S = v.P @ A11 - Y @ A12
        drive = v.P @ (TW - B11 @ N) + Y @ (B12 @ N)
        found.append(dissipation(S + S.T, v.P @ TB * rho, drive, shown, q, m, v.gamma_2, exact))
        found.append(np.block([[-v.P * radius, S], [S.T, -v.P * radius]]))
    return found


def _stacked(blocks: list[Exact]) -> Exact:
    """Lower triangles one after another, so that a product with another is the sum of the inner products."""
    return np.concatenate([
        np.array([block[i, j] * (1 if i == j else 2) for i in range(len(block)) for j in range(i + 1)])
        for block in blocks
    ])  # fmt: skip


def _unstacked(z: Array, sizes: list[int]) -> list[Array]:
    """Symmetric matrices of their lower triangles."""
    found, at = [], 0
    for n in sizes:
        block = np.zeros((n, n), z.dtype)
        for i in range(n):
            block[i, : i + 1] = block[: i + 1, i] = z[at : at + i + 1]
            at += i + 1
        found.append(block)
    return found


def _proposal(rows: Array, sizes: list[int]) -> tuple[list[Array], float] | None:
    """Multipliers Z that prove nearly the best bound, and how far they are inside the cone."""
    Z, inside = [cp.Variable((n, n), symmetric=True) for n in sizes], cp.Variable()
    asked = np.array([-1.0, *np.zeros(len(rows) - 2)])
    weights = np.abs(rows[1:]).max(axis=1)
    held: list[cp.Constraint] = [
        _product(row / weight, Z, sizes) == float(right)
        for row, weight, right in zip(rows[1:], weights, asked / weights, strict=True)
    ]
    bound = _product(rows[0], Z, sizes)
    run(cp.Problem(cp.Maximize(bound), [*held, *(each >> 0 for each in Z)]))
    if bound.value is None:
        return None
    held.append(bound >= (1.0 - SLACK) ** 2 * float(bound.value))
    held += [each >> inside * np.eye(each.shape[0]) for each in Z]
    run(cp.Problem(cp.Maximize(inside), held))
    if inside.value is None or not float(inside.value) > 0.0:
        return None
    found = [np.asarray(each.value) for each in Z]
    return [0.5 * (each + each.T) for each in found], float(inside.value)


def _product(row: Array, Z: list[cp.Variable], sizes: list[int]) -> cp.Expression:
    """Sum of the inner products of the matrices that are stacked in a row with Z."""
    parts = [0.5 * (part + np.diag(np.diag(part))) for part in _unstacked(row, sizes)]
    products = [trace(part @ each) for part, each in zip(parts, Z, strict=True)]  # type: ignore[no-untyped-call]
    return cast(cp.Expression, sum(products))


def _proved(rows: Exact, Z: list[Array], sizes: list[int], inside: float) -> Fraction:
    """The bound on gamma^2 of Z after the exact projection; zero where it is not inside the cone."""
    z = np.concatenate([exact(each)[np.tril_indices(len(each))] for each in Z])
    asked = np.array([Fraction(-1 if i == 0 else 0) for i in range(len(rows) - 1)], dtype=object)
    moved = rows[1:].T @ solved(rows[1:] @ rows[1:].T, asked - rows[1:] @ z)
    margin = exact(0.5 * inside)[()]
    for each, change in zip(Z, _unstacked(moved, sizes), strict=True):
        held = is_positive_definite(exact(each) - exact(np.eye(len(each))) * margin)
        if not held or (change * change).sum() >= margin * margin:
            return Fraction(0)
    return Fraction(rows[0] @ (z + moved))
