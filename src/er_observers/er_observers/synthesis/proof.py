r"""The inequalities of every theorem for given gains, proved after rounding, between the nodes as well.

Written from the dissipation inequality, not from the solver's blocks: for all zeta, d and w

.. math::  2 \zeta^T P(\rho) \big(M \zeta + b \rho d + W w\big) \pm \nu \zeta^T P_1 \zeta + |h|^2
           - \gamma^2 |w|^2 + l\,[s, d]\, q\, [s, d]^T < 0

with ``h = H (R zeta - S n)``, ``s = Gamma (R zeta - S n)`` (`er_observers.law`). Between two nodes M, J
and l are straight lines and so is P, so each matrix is a quadratic in rho. A quadratic lies in the
hull of its three Bernstein coefficients ``F(a), 2 F(m) - (F(a) + F(b)) / 2, F(b)``, m the middle: where
these are definite, it is definite for every duty between a and b. No grid is left to trust.

Source: Bernstein's bound: Garloff 1993.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from er_models.exact import exact, is_positive_definite
from er_models.linear import LinearForm
from er_models.model import Array

from er_observers.scaling import Scaling
from er_observers.synthesis.spec import Output, Solution, Spec

Convert = Callable[[object], Any]
"""Doubles to the numbers that are reckoned with: doubles again, or fractions."""
Point = tuple[int, int]
"""Two nodes; the duty in the middle between them."""
_Build = Callable[[Point, Convert], Any]


class Margins(NamedTuple):
    """Distance of each inequality from equality: smallest eigenvalue in scaled coordinates.

    lyapunov, regions: over the nodes; dissipation: per Bernstein coefficient, node or middle.
    """

    lyapunov: float
    dissipation: tuple[float, ...]
    regions: tuple[float, ...]

    @property
    def smallest(self) -> float:
        """The smallest of all; above zero when everything holds."""
        return min(self.lyapunov, *self.dissipation, *self.regions)


@dataclass(frozen=True, eq=False)
class ErrorSystem:
    """Constant matrices of the error: b (N, 1) at duty 1, G (1, N), G_w (1, w), H (p, N), H_w (p, w), W (K, N, w)."""

    b: Array
    G: Array
    G_w: Array
    H: Array
    H_w: Array
    W: Array


@dataclass(frozen=True, eq=False)
class Claim:
    """What is to be proved: what gains must do for a linear form, and the solution to check.

    common: the same law with one Lyapunov function for all duties, however they jump, where the
    solution's own changes with the duty.
    """

    form: LinearForm
    output: Output
    spec: Spec
    scaling: Scaling
    solution: Solution
    common: Solution | None = None
    sizes: Array = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "sizes", self.solution.law.sizes(self.scaling.state))

    @property
    def jumping(self) -> Solution:
        """The solution whose Lyapunov function bears jumps of the duty."""
        return self.solution if self.common is None else self.common

    @cached_property
    def error(self) -> ErrorSystem:
        """The error's matrices, as the numbers that run."""
        f, law, N = self.form, self.solution.law, self.spec.noise_matrix()
        road = law.T @ self.spec.input_matrix(f)
        return ErrorSystem(
            b=(law.T @ f.B)[:, None],
            G=(f.Gamma @ law.R)[None, :],
            G_w=-(f.Gamma @ law.S @ N)[None, :],
            H=self.output.rows @ law.R,
            H_w=-self.output.rows @ law.S @ N,
            W=np.array([road - J @ N for J in law.J]),
        )

    def dissipation(self, s: Solution, sign: int, point: Point, convert: Convert) -> Any:
        """Minus the dissipation matrix at a point, scaled to its variables; sign of the duty's rate."""
        e, q = self.error, convert(self.spec.sector.form)
        mid = partial(_middle, point=point, convert=convert)
        rho, m, gamma = mid(s.law.rho), mid(s.multipliers), convert(s.gamma)
        P_1 = convert(s.P_1)
        P = convert(s.P) + P_1 * rho
        decay, W = P @ mid(s.law.M), mid(e.W)
        b, *shown = (convert(v) for v in (e.b, e.G, e.G_w, e.H, e.H_w))
        state = decay + decay.T + P_1 * convert(sign * s.rate)
        matrix = dissipation(state, P @ b * rho, P @ W, shown, q, m, gamma * gamma, convert)
        wide = np.linalg.norm(e.G * self.sizes)
        sizes = convert(np.concatenate([self.sizes, [wide], np.ones(W.shape[1])]))
        return -matrix * sizes * sizes[:, None]

    def region(self, s: Solution, which: str, point: Point, convert: Convert) -> Any:
        """Matrix, positive definite when the poles at a point lie in the disc, the half-plane or the cone."""
        mid = partial(_middle, point=point, convert=convert)
        P = convert(s.P) + convert(s.P_1) * mid(s.law.rho)
        S = P @ mid(s.law.M)
        x, rate = convert(self.sizes), convert(self.scaling.rate)
        if which == "decay":
            return -(S + S.T + P * convert(2.0 * self.spec.decay)) * x * x[:, None] / rate
        if which == "disc":
            whole, skew = P * convert(self.spec.radius), S
        else:
            whole = -(S + S.T) * convert(np.sqrt(1.0 - self.spec.damping**2))
            skew = (S - S.T) * convert(self.spec.damping)
        x = np.concatenate([x, x])
        return np.block([[whole, -skew], [-skew.T, whole]]) * x * x[:, None] / rate

    def lyapunov(self, s: Solution, point: Point, convert: Convert) -> Any:
        """P at a point in scaled states."""
        x = convert(self.sizes)
        P = convert(s.P) + convert(s.P_1) * _middle(s.law.rho, point=point, convert=convert)
        return P * x * x[:, None]


def dissipation(
    state: Any, kick: Any, drive: Any, shown: Sequence[Any], q: Any, m: Any, gamma_2: Any, convert: Convert
) -> Any:  # fmt: skip
    """Dissipation matrix of (zeta, d, w), for P M + M' P (N, N), P b rho (N, 1) and P W (N, w).

    shown: G, G_w, H, H_w of `ErrorSystem`; q (2, 2): form of the sector, m its multiplier; gamma_2: gamma squared.
    """
    G, G_w, H, H_w = shown
    gate = kick + G.T * (m * q[0, 1])
    entry = drive + H.T @ H_w + G.T @ G_w * (m * q[0, 0])
    through = G_w * (m * q[0, 1])
    corner = H_w.T @ H_w + G_w.T @ G_w * (m * q[0, 0])
    return np.block([
        [state + H.T @ H + G.T @ G * (m * q[0, 0]), gate, entry],
        [gate.T, convert(np.ones((1, 1))) * (m * q[1, 1]), through],
        [entry.T, through.T, corner - convert(np.eye(drive.shape[1])) * gamma_2],
    ])  # fmt: skip


def prove(claim: Claim) -> tuple[Margins, str]:
    """Margins, and the name of the first inequality that does not hold exactly ('' for none).

    The exact test is made with half the margin taken off, so that the margin itself is proved to a
    factor of two.
    """
    margins, failed = _prove(claim, claim.solution)
    if claim.common is not None and not failed:
        more, failed = _prove(claim, claim.common)
        failed = failed and f"common Lyapunov function: {failed}"
        margins = Margins(
            min(margins.lyapunov, more.lyapunov),
            margins.dissipation + more.dissipation,
            margins.regions + more.regions,
        )
    return margins, failed


def gaps(claim: Claim) -> list[float]:
    """Duties in the middle between two nodes where an inequality does not hold, in floating point."""
    s, found = claim.solution, []
    for a, b in pairwise(range(len(s.law.rho))):
        builds: list[_Build] = [partial(claim.dissipation, s, sign) for sign in (1, -1)]
        builds += [partial(claim.region, s, name) for name in _regions(claim.spec)]
        for build in builds:
            matrix = _bernstein(build, (a, b), _floats)
            if not float(np.linalg.eigvalsh(0.5 * (matrix + matrix.T))[0]) > 0.0:
                found.append(0.5 * float(s.law.rho[a] + s.law.rho[b]))
                break
    return found


def _prove(claim: Claim, s: Solution) -> tuple[Margins, str]:
    """As `prove`, for one Lyapunov function of the claim's law."""
    nodes = [(k, k) for k in range(len(s.law.rho))]
    points = nodes + (list(pairwise(range(len(s.law.rho)))) if np.any(s.P_1) else [])
    signs = (1, -1) if np.any(s.P_1) else (1,)
    failed = [] if np.all(s.multipliers > 0.0) else ["a multiplier of the sector is not positive"]

    def check(name: str, build: _Build, where: list[Point]) -> tuple[float, ...]:
        found = []
        for point in where:
            rho = 0.5 * (s.law.rho[point[0]] + s.law.rho[point[1]])
            margin, text = _check(f"{name} at rho = {rho:g}", partial(_bernstein, build, point))
            found.append(margin)
            failed.extend([text] if text else [])
        return tuple(found)

    lyapunov = check("P", partial(claim.lyapunov, s), nodes)
    inside: tuple[float, ...] = ()
    for sign in signs:
        inside += check("dissipation", partial(claim.dissipation, s, sign), points)
    regions: tuple[float, ...] = ()
    for name in _regions(claim.spec):
        regions += check(name, partial(claim.region, s, name), points)
    return Margins(min(lyapunov), inside, regions), failed[0] if failed else ""


def _regions(spec: Spec) -> list[str]:
    """Names of the regions that the poles must lie in."""
    asked = {"decay": spec.decay > 0.0, "cone": spec.damping > 0.0}
    return ["disc", *(name for name, wanted in asked.items() if wanted)]


def _bernstein(build: _Build, point: Point, convert: Convert) -> Any:
    """The matrix at a node; between two nodes the middle Bernstein coefficient."""
    a, b = point
    if a == b:
        return build(point, convert)
    ends = build((a, a), convert) + build((b, b), convert)
    return build(point, convert) * convert(2.0) - ends * convert(0.5)


def _middle(values: Array, *, point: Point, convert: Convert) -> Any:
    """Mean of the entries (K, ...) at two nodes."""
    a, b = (convert(values[k]) for k in point)
    return a if point[0] == point[1] else (a + b) * convert(0.5)


def _check(name: str, build: Callable[[Convert], Any]) -> tuple[float, str]:
    """Margin of one inequality, and what fails in it ('' when it holds)."""
    matrix = build(_floats)
    margin = float(np.linalg.eigvalsh(0.5 * (matrix + matrix.T))[0])
    if margin > 0.0:
        whole = build(exact)
        if is_positive_definite(whole - exact(np.eye(whole.shape[0])) * exact(0.5 * margin)):
            return margin, ""
    return margin, f"{name} has the margin {margin:.3g}"


def _floats(values: object) -> Array:
    """The plain conversion beside `exact`."""
    return np.asarray(values, float)
