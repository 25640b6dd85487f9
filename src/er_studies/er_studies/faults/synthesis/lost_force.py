r"""Descriptor H-infinity observer of the force that a damper has lost, from the corrected (2.19).

With :math:`q = [x, v, F_{er}, f]`, f the lost force, and the wheel's acceleration by its sensor in the place of road
and tyre, (2.19) is E q' = A q + B(\rho) \Phi - b y_{us} with E = [I, 0]; the body's acceleration, x and v are measured.
T E + Q C = I is solved by T = [I; t], Q = [0; q] with q = [m_s, 0, 0]: no noise is differentiated, and

.. math::  \hat f = m_s y_s + (k_s + k_0) \hat x + c_0 \hat v + \hat F_{er}, \quad
           \hat q' = A_0 \hat q + B \rho \Phi(\hat q) + b (y_s - y_{us}) + K ([y_x, y_v]^T - C \hat q)

for the first three. The gain from unit noises n to the error of f, for every duty from 0 to the greatest one and any
gate of slope 0 to 1, is below gamma where with Y = P K

.. math::

    \begin{bmatrix} S + S^T + h^T h & P B \rho + l \Gamma^T & P W - Y N + h^T D \\
    * & -2 l & 0 \\ * & * & D^T D - \gamma^2 I \end{bmatrix} < 0, \quad S = P A_0 - Y C.

With gamma SLACK times the least one, trace (W - K N)' P (W - K N), which bounds the variance of the error for white
noise and a shut gate, is made small. Poles lie in the disc ``[-R P, S; S', -R P] < 0``. The K that is
returned is proved again in fractions, with Y = P K of the rounded P.

Source: thesis (2.19); Darouach and Boutayeb 1995 (descriptor observers); the sector as in `lmi`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import cvxpy as cp
import numpy as np
from cvxpy.atoms.affine.bmat import bmat
from cvxpy.atoms.affine.trace import trace
from er_models.exact import exact, is_positive_definite
from er_models.forms.linearise import rounded
from er_models.model import Array, Model
from er_models.static_damper import static_damper
from er_observers.synthesis.solver import run
from er_observers.synthesis.spec import SynthesisFailed

THEOREM = "lost force (2.19)"
RADIUS = 200.0
"""Greatest pole [1/s]: the rate of samples."""
SLACK = 1.5
"""Gamma over the least one, which leaves room for the variance and for a proof."""
_RATE = 100.0
"""One over the unit of time [1/s]."""


@dataclass(frozen=True, eq=False)
class Design:
    """The scaled problem, B at the greatest duty.

    A (3, 3), B (3, 1), C (2, 3), W (3, 4), N (2, 4), h (1, 3), D (1, 4), gate (1, 3); units of the state (3,);
    noises (4,): both accelerations [m/s2], x [m], v [m/s].
    """

    A: Array
    B: Array
    C: Array
    W: Array
    N: Array
    h: Array
    D: Array
    gate: Array
    units: Array
    noise: Array


@dataclass(frozen=True, eq=False)
class LostForce:
    """K (3, 2) in SI units, gamma, and what proves it: scaled P, the multiplier."""

    K: Array
    gamma: float
    P: Array
    multiplier: float


def design(model: Model, noise: Array, duty: float = 1.0) -> Design:
    """The problem of a car; noise (3,): deviations of acceleration, deflection, velocity; duty: the greatest one."""
    d, car = static_damper(model), model.effects["quarter_car"]
    tau = model.value("response", "tau") if "response" in model.effects else 1.0 / RADIUS
    one = car["m_s"] * noise[0]
    units = 10.0 * np.array([noise[1], noise[2], one])
    sizes = noise[[0, 0, 1, 2]]
    A = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, -1.0 / tau]])
    B = np.array([[0.0], [0.0], [float(d.height(duty)) / tau]])
    W = np.zeros((3, 4))
    W[1, 0], W[1, 1] = -sizes[0], sizes[1]
    C, N = np.eye(2, 3) / noise[1:, None], np.eye(2, 4, 2)
    h = np.array([[car["k_s"] + d.k0, d.c0, 1.0]]) / one
    D = np.array([[-1.0, 0.0, 0.0, 0.0]])
    gate = np.array([[d.k1, d.c1, 0.0]])
    down, rate = units[:, None], _RATE
    return Design(
        A * units / down / rate, B / down / rate, C * units, W / down / rate, N, h * units, D,
        gate * units, units, sizes,
    )  # fmt: skip


def solve(p: Design) -> LostForce:
    """The least gamma with some room; raises `SynthesisFailed` where there is none, or no proof."""
    P, Y = cp.Variable((3, 3), symmetric=True), cp.Variable((3, 2))
    sector, square, t = (
        cp.Variable(nonneg=True),
        cp.Variable(nonneg=True),
        cp.Variable(nonneg=True),
    )
    held = [m >> t * np.eye(m.shape[0]) for m in matrices(p, P, Y, sector, square, bmat)]
    status = run(cp.Problem(cp.Minimize(square), held))
    if square.value is None:
        raise SynthesisFailed(THEOREM, "no gain was found", status)
    gamma = SLACK * float(np.sqrt(square.value))
    noise = P @ p.W - Y @ p.N
    variance = cp.Variable((4, 4), symmetric=True)
    bound = bmat([[variance, noise.T], [noise, P]])  # type: ignore[no-untyped-call]
    held += [square == gamma**2, bound >> 0]
    total = trace(variance)  # type: ignore[no-untyped-call]
    run(cp.Problem(cp.Minimize(total), [*held, t == 0.0]))
    if variance.value is not None:
        held.append(total <= SLACK * float(np.trace(variance.value)))
    status = run(cp.Problem(cp.Maximize(t), [*held, t <= 1.0]))
    if P.value is None or Y.value is None or sector.value is None:
        raise SynthesisFailed(THEOREM, f"no margin at gamma {gamma:.4g}", status)
    K = np.linalg.solve(P.value, Y.value) * p.units[:, None] * _RATE
    K = K / np.array([p.noise[2], p.noise[3]])
    symmetric = rounded(np.asarray(P.value + P.value.T) / 2.0)
    solution = LostForce(K, gamma, symmetric, float(sector.value))
    if not proved(p, solution):
        raise SynthesisFailed(THEOREM, "the solution found is not proved", status)
    return solution


def proved(p: Design, solution: LostForce) -> bool:
    """Whether all inequalities hold for K in exact fractions, at both ends of the duty and so between them."""
    parts: dict[str, Any] = {
        name: exact(getattr(p, name)) for name in ("A", "B", "C", "W", "N", "h", "D", "gate")
    }
    given = Design(**parts, units=p.units, noise=p.noise)
    sector, square = exact(solution.multiplier), exact(solution.gamma) ** 2
    scale = exact(p.noise[2:]) / (exact(p.units)[:, None] * int(_RATE))
    P, K = exact(solution.P), exact(solution.K) * scale
    Y = P @ K
    return all(is_positive_definite(m) for m in matrices(given, P, Y, sector, square, np.block))


def matrices(
    p: Design, P: Any, Y: Any, sector: Any, square: Any, block: Callable[[Any], Any]
) -> list[Any]:
    """All that must be positive definite: P, the disc, the gain without field and with the greatest one."""
    S, radius = P @ p.A - Y @ p.C, int(RADIUS / _RATE)
    found = [P, block([[radius * P, -S], [-S.T, radius * P]])]
    noise = P @ p.W - Y @ p.N + p.h.T @ p.D
    one, nothing = np.ones((1, 1), int), np.zeros((1, 4), int)
    for duty in (0, 1):
        gate = P @ p.B * duty + p.gate.T * sector
        found.append(block([
            [-(S + S.T) - p.h.T @ p.h, -gate, -noise],
            [-gate.T, 2 * sector * one, nothing],
            [-noise.T, nothing.T, square * np.eye(4, dtype=int) - p.D.T @ p.D],
        ]))  # fmt: skip
    return found
