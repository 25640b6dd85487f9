r"""Stability of what really runs: the error from one substep of the kernel to the next.

The kernel is exact in the linear part and takes the mean of the gate along each substep. For two
runs of it that differ by e_0 at the start, the mean value theorem gives
``d = k_0 Gamma e_0 + k_1 Gamma e_1`` with

.. math::  k_0 = \int (1 - \theta) g\, d\theta, \quad k_1 = \int \theta g\, d\theta, \quad
           0 \le g \le 1

so (k_0, k_1) lies in a lens whose edge is reached by gates that are open on one part of the
substep. Where the map shrinks the Lyapunov function of the theorem over the whole lens and every
duty, any two runs converge, however the duty jumps from sample to sample.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from er_models.linear import LinearForm
from er_models.model import Array
from scipy.linalg import expm

from er_observers.synthesis.spec import Solution, Spec


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


def contraction(
    form: LinearForm, solution: Solution, spec: Spec, steps: tuple[float, ...], duties: int = 21
) -> Contraction:
    """Slowest decay of ``sqrt(e' P e)`` over step lengths [s], duties and the lens."""
    root = np.linalg.cholesky(solution.P).T
    back = np.linalg.inv(root)
    worst, loop = Contraction(float("inf"), 0.0, 0.0, (0.0, 0.0), 0.0), -float("inf")
    for step in steps:
        for rho in np.linspace(spec.rho[0], spec.rho[1], duties):
            linear, kick = substep(form, solution.gain(float(rho), spec), float(rho), step)
            loop = max(loop, float(form.Gamma @ kick))
            for gate in lens():
                growth = np.linalg.norm(root @ error_map(linear, kick, form, gate) @ back, 2)
                decay = float(-np.log(growth) / step)
                if decay < worst.decay:
                    at = (float(gate[0]), float(gate[1]))
                    worst = Contraction(decay, step, float(rho), at, 0.0)
    return worst._replace(loop=loop)


def substep(form: LinearForm, gain: Array, rho: float, step: float) -> tuple[Array, Array]:
    """Exact linear map (n, n) of one substep and the effect (n,) of the gate held at one."""
    whole = np.zeros((form.n + 1, form.n + 1))
    whole[:-1, :-1] = form.A - gain @ form.C
    whole[:-1, -1] = form.B * rho
    moved = expm(whole * step)
    return moved[:-1, :-1], moved[:-1, -1]


def error_map(linear: Array, kick: Array, form: LinearForm, gate: Array) -> Array:
    """Map (n, n) of the difference of two runs over one substep, for (k_0, k_1) = gate (2,)."""
    loop = np.outer(kick, form.Gamma)
    return np.linalg.solve(np.eye(form.n) - gate[1] * loop, linear + gate[0] * loop)
