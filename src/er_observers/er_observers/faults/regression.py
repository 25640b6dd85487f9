r"""One row of the regression that (6.8) is: linear in f_2 k_0, f_2 f_3 c_0, f_1 f_2 f_3, and in errors of the model.

.. math::  -m_s \ddot z_s - k_s x = f_2 k_0 x + f_2 f_3 (c_0 v + f_1 F_{er})
           + \delta_s k_s x + b + f_1 f_2 f_3 \sum_q \delta_q\, \partial F_{er} / \partial \ln q

with q = tau, k_1, c_1. A wrong mass is no column: it scales all others alike (`prior.py`), and as a column it would
explain everything, the noise of the acceleration included. Where a force is given it takes the place of the left side,
and delta_s is not asked for.
F_er follows the healthy damper; between samples the velocity is the cubic through both ends and their accelerations.
Where the gate is open an error of v makes one of F_er, which lasts as long as the fluid: such rows err alike, and least
squares would waste most of what they say. A Kalman filter of F_er alone makes innovations of them, rows that err on
their own; phi becomes the derivative of the innovation, the filter's own answer to beta included.

Source: thesis (6.8), (1.12), (1.8); Ljung 1979 (recursive prediction error method).
"""

from __future__ import annotations

import math

from er_models.model import Array

from er_observers.observers.compiled import compiled
from er_observers.observers.gate import mean_gate

NAMES = ("k0", "c0", "f_c", "k_s", "offset", "tau", "k1", "c1")
"""Unknowns: shares of the first three (1 healthy) and relative errors; offsets in N."""
K0, C0, SIGMA, BETA, K1, C1, TAU, M_S, K_S = range(9)
"""Places of the damper's and the body's constants in p (9,)."""
S, F_ER, BY_TAU, BY_K1, BY_C1, DOUBT = range(6)
"""Places in the fluid (6,): argument of the gate, F_er [N], its derivatives by logarithms, its variance [N2]."""
SUBSTEPS = 4
_NEAR = 1e-6
_BLUR = 0.0
"""The mean of tanh(s + e) over a Gaussian e of variance q is that of tanh(s / sqrt(1 + pi q / 2)); twice that, since
between two samples v is less certain than at them."""
_ALIKE = 6.0
"""An error of v is the same in all substeps of a sample, and much the same in the next one."""


@compiled
def advance(p: Array, fluid: Array, x: tuple[float, float], v: tuple[float, float],
            a: tuple[float, float], variance: float, duty: float, dt: float) -> None:  # fmt: skip
    """Move the fluid (6,) dt [s] on, in place; x, v, a: deflection and its rates at both ends, duty: in between.

    variance: of v, which makes that of F_er where the gate is open.
    """
    height = p[SIGMA] * duty ** p[BETA] if duty > 0.0 else 0.0
    before = x[0]
    for j in range(1, SUBSTEPS + 1):
        h = j / SUBSTEPS
        g = 1.0 - h
        now = x[0] + h * (x[1] - x[0])
        rate = g * g * (1.0 + 2.0 * h) * v[0] + h * h * (1.0 + 2.0 * g) * v[1]
        rate += h * g * dt * (g * a[0] - h * a[1])
        _substep(p, fluid, before, now, rate, variance, height, dt / SUBSTEPS)
        before = now


@compiled
def _substep(
    p: Array,
    fluid: Array,
    x_0: float,
    x_1: float,
    v: float,
    variance: float,
    height: float,
    dt: float,
) -> None:
    """One piece of `advance`; the gate acts with its mean, or at once where there is no response time."""
    s_0, s_1 = fluid[S], (p[K1] * x_1 + p[C1] * v) / math.sqrt(1.0 + _BLUR * p[C1] ** 2 * variance)
    slow = p[TAU] > 0.0
    kept = math.exp(-dt / p[TAU]) if slow else 0.0
    gate, argument, lean = math.tanh(s_1), s_1, p[K1] * x_1
    slope = 1.0 - gate * gate
    if slow:
        argument, lean = 0.5 * (s_0 + s_1), 0.5 * p[K1] * (x_0 + x_1)
        if abs(s_1 - s_0) > _NEAR:
            slope = (gate - math.tanh(s_0)) / (s_1 - s_0)
        gate = mean_gate(s_0, s_1)[0]
        lag = kept * dt / p[TAU] * (fluid[F_ER] - height * gate)
        fluid[BY_TAU] = kept * fluid[BY_TAU] + lag
    new = (1.0 - kept) * height
    fluid[BY_K1] = kept * fluid[BY_K1] + new * slope * lean
    fluid[BY_C1] = kept * fluid[BY_C1] + new * slope * (argument - lean)
    fluid[DOUBT] = kept * kept * fluid[DOUBT] + _ALIKE * variance * (new * slope * p[C1]) ** 2
    fluid[F_ER] = kept * fluid[F_ER] + new * gate
    fluid[S] = s_1


@compiled
def row(p: Array, fluid: Array, x: float, v: float, phi: Array) -> None:
    """Fill phi (N,) of the sprung mass's row."""
    phi[0], phi[1], phi[2] = p[K0] * x, p[C0] * v, fluid[F_ER]
    phi[3], phi[4] = p[K_S] * x, 1.0
    phi[5], phi[6], phi[7] = fluid[BY_TAU], fluid[BY_K1], fluid[BY_C1]


@compiled
def innovate(
    fluid: Array, lean: Array, expected: Array, y: float, variance: float, phi: Array
) -> float:
    """Turn a row into an innovation, in place, and correct F_er by it; returns its left side.

    lean (N,): derivative of F_er by the unknowns since y corrects it; expected (N,): the unknowns that the filter goes
    by; variance: of y [N2], without that of F_er.
    """
    share, doubt, error = expected[2], fluid[DOUBT], y
    for i in range(phi.size):
        error -= phi[i] * expected[i]
        phi[i] += share * lean[i]
    gain = doubt * share / (variance + share * share * doubt)
    for i in range(phi.size):
        lean[i] -= gain * phi[i]
    fluid[F_ER] += gain * error
    fluid[DOUBT] = doubt * (1.0 - gain * share)
    for i in range(phi.size):
        error += phi[i] * expected[i]
    return error


@compiled
def body_force(p: Array, x: float, a_s: float) -> float:
    """What the sprung mass says of the damper's force [N]."""
    return float(-p[M_S] * a_s - p[K_S] * x)
