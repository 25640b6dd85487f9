r"""The inequalities of the polytopic theorem for given gains, proved after rounding.

Written from the dissipation inequality, not from the solver's blocks: for all e, d and w

.. math::  2 e^T P \big((A - L C) e + B \rho d + (W - L N) w\big) + |H e|^2 - \gamma^2 |w|^2
           + l\,[\Gamma e, d]\, q\, [\Gamma e, d]^T < 0
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from er_models.linear import LinearForm
from er_models.model import Array

from er_observers.synthesis.exact import exact, is_positive_definite
from er_observers.synthesis.scaling import Scaling
from er_observers.synthesis.spec import Output, Solution, Spec

Convert = Callable[[object], Any]
"""Doubles to the numbers that are reckoned with: doubles again, or fractions."""


class Margins(NamedTuple):
    """Distance of each inequality from equality: smallest eigenvalue in scaled coordinates."""

    lyapunov: float
    dissipation: tuple[float, ...]
    disc: tuple[float, ...]

    @property
    def smallest(self) -> float:
        """The smallest of all; above zero when everything holds."""
        return min(self.lyapunov, *self.dissipation, *self.disc)


@dataclass(frozen=True, eq=False)
class Claim:
    """What is to be proved: what gains must do for a linear form, and the solution to check."""

    form: LinearForm
    output: Output
    spec: Spec
    scaling: Scaling
    solution: Solution

    def dissipation(self, end: int, convert: Convert) -> Any:
        """Minus the dissipation matrix at one end of the duty's range, scaled to its variables."""
        f, spec, s = self.form, self.spec, self.solution
        A, B, C, Gamma = (convert(m) for m in (f.A, f.B[:, None], f.C, f.Gamma[None, :]))
        P, L, m, H = (convert(v) for v in (s.P, s.L[end], s.multipliers[end], self.output.rows))
        W, N = convert(spec.input_matrix(f)), convert(spec.noise_matrix())
        q, rho, gamma = convert(spec.sector.form), convert(spec.rho[end]), convert(s.gamma)
        decay = P @ (A - L @ C)
        to_gate = P @ B * rho + Gamma.T * (m * q[0, 1])
        to_noise = P @ (W - L @ N)
        gap = convert(np.zeros((1, W.shape[1])))
        matrix = np.block([
            [decay + decay.T + H.T @ H + Gamma.T @ Gamma * (m * q[0, 0]), to_gate, to_noise],
            [to_gate.T, convert(np.ones((1, 1))) * (m * q[1, 1]), gap],
            [to_noise.T, gap.T, convert(-np.eye(W.shape[1])) * (gamma * gamma)],
        ])  # fmt: skip
        x = self.scaling.state
        gate = np.linalg.norm(f.Gamma * x)
        sizes = convert(np.concatenate([x, [gate], np.ones(W.shape[1])]))
        return -matrix * sizes * sizes[:, None]

    def disc(self, end: int, convert: Convert) -> Any:
        """Matrix, positive definite when every pole of A - L C lies within the radius."""
        P, A, C = convert(self.solution.P), convert(self.form.A), convert(self.form.C)
        S = P @ (A - convert(self.solution.L[end]) @ C)
        whole = P * convert(self.spec.radius)
        x = convert(np.concatenate([self.scaling.state, self.scaling.state]))
        rate = convert(self.scaling.rate)
        return np.block([[whole, -S], [-S.T, whole]]) * x * x[:, None] / rate

    def lyapunov(self, convert: Convert) -> Any:
        """P in scaled states."""
        x = convert(self.scaling.state)
        return convert(self.solution.P) * x * x[:, None]


def prove(claim: Claim) -> tuple[Margins, str]:
    """Margins, and the name of the first inequality that does not hold exactly ('' for none).

    The exact test is made with half the margin taken off, so that the margin itself is proved to a
    factor of two.
    """
    ends = list(enumerate(claim.spec.rho))
    lyapunov = _check("P", claim.lyapunov)
    inside = [
        _check(f"dissipation at rho = {r:g}", partial(claim.dissipation, i)) for i, r in ends
    ]
    disc = [_check(f"disc at rho = {r:g}", partial(claim.disc, i)) for i, r in ends]
    margins = Margins(lyapunov[0], tuple(m for m, _ in inside), tuple(m for m, _ in disc))
    failed = [text for _, text in (lyapunov, *inside, *disc) if text]
    if not np.all(claim.solution.multipliers > 0.0):
        failed.insert(0, "a multiplier of the sector is not positive")
    return margins, failed[0] if failed else ""


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
