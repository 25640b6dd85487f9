r"""Advances ``x' = M(rho) x + b rho tanh(Gamma x) + L(rho) y`` over one sample, compiled.

The linear part with first-order-hold y is exact (phi functions of h M by scaling and doubling).
The gate enters with its mean over the straight line from Gamma x at the start to Gamma x at the
end of a substep,

.. math::  \bar\varphi = \frac{\ln\cosh s_1 - \ln\cosh s_0}{s_1 - s_0}

which integrates the passage through the steep part exactly, however few steps it takes, and keeps
the slope in [0, 1] that the certificate rests on. The end value solves one scalar equation,
monotone, by a bracketed Newton method.

Source: Hochbruck and Ostermann 2010 (phi functions); Quispel and McLaren 2008 (average vector
field).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeVar, cast

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

SUBSTEP = 3.125e-4
"""Longest substep [s]; the certificate shows that the discrete observer converges with it."""

_TERMS = 13
_NEAR = 1e-2
_SATURATED = 20.0
_LN_2 = math.log(2.0)


F = TypeVar("F", bound=Callable[..., object])


def compiled(function: F) -> F:
    """The function compiled, on disk where there is a place for it and in memory where not."""
    try:
        return cast(F, njit(cache=True, error_model="numpy")(function))
    except RuntimeError:  # numba finds no folder it may write to
        return cast(F, njit(error_model="numpy")(function))


def substeps(dt: float) -> int:
    """Substeps for a sample of length dt [s]."""
    return max(1, math.ceil(dt / SUBSTEP - 1e-6))


@compiled
def _multiply(a: Array, b: Array, out: Array) -> None:
    """Product a b of square matrices (n, n) into out."""
    n = a.shape[0]
    for i in range(n):
        for j in range(n):
            total = 0.0
            for k in range(n):
                total += a[i, k] * b[k, j]
            out[i, j] = total


@compiled
def _apply(a: Array, x: Array) -> Array:
    """Product a x, (n, m) times (m,)."""
    out = np.zeros(a.shape[0])
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            out[i] += a[i, j] * x[j]
    return out


@compiled
def _small_phi(a: Array, phi: Array, product: Array) -> None:
    """Fill phi (3, n, n) for a matrix a (n, n) of norm below one, by Taylor series."""
    n = a.shape[0]
    phi[2, :, :] = 0.0
    for k in range(_TERMS, 1, -1):  # Horner: phi_2 = sum of a^j / (j + 2)!
        _multiply(a, phi[2], product)
        for i in range(n):
            for j in range(n):
                phi[2, i, j] = (product[i, j] + (1.0 if i == j else 0.0)) / k
    for level in range(1, -1, -1):
        _multiply(a, phi[level + 1], phi[level])
        for i in range(n):
            phi[level, i, i] += 1.0


@compiled
def _double_phi(phi: Array, square: Array, product: Array) -> None:
    """From phi of a to phi of 2 a, in place."""
    n = square.shape[0]
    _multiply(phi[1], phi[1], square)
    _multiply(phi[0], phi[1], product)
    for i in range(n):
        for j in range(n):
            phi[2, i, j] = 0.25 * (square[i, j] + 2.0 * phi[2, i, j])
            phi[1, i, j] = 0.5 * (product[i, j] + phi[1, i, j])
    _multiply(phi[0], phi[0], square)
    phi[0, :, :] = square


@compiled
def phi_functions(m: Array) -> Array:
    """The three matrices (3, n, n) phi_0 = exp(m), phi_1 and phi_2 of m (n, n)."""
    n = m.shape[0]
    norm = 0.0
    for i in range(n):
        norm = max(norm, np.abs(m[i]).sum())
    doublings, scale = 0, 1.0
    while norm * scale > 1.0 and doublings < 60:
        scale *= 0.5
        doublings += 1
    phi, square, product = np.empty((3, n, n)), np.empty((n, n)), np.empty((n, n))
    _small_phi(m * scale, phi, product)
    for _ in range(doublings):
        _double_phi(phi, square, product)
    return phi


@compiled
def _log_cosh(s: float) -> float:
    """Natural logarithm of cosh s, without overflow."""
    size = abs(s)
    if size > _SATURATED:
        return size - _LN_2
    return size + math.log1p(math.exp(-2.0 * size)) - _LN_2


@compiled
def _tanh(s: float) -> float:
    """Hyperbolic tangent; where it is one in doubles, without asking the library."""
    return math.tanh(s) if abs(s) <= _SATURATED else math.copysign(1.0, s)


@compiled
def mean_gate(s_0: float, s_1: float) -> tuple[float, float]:
    """Mean of tanh between s_0 and s_1, and its derivative by s_1 (0 to 1/2)."""
    return _mean_gate(s_0, _log_cosh(s_0), s_1)


@compiled
def _mean_gate(s_0: float, area_0: float, s_1: float) -> tuple[float, float]:
    """As `mean_gate`, with the integral of tanh up to s_0 at hand."""
    step = s_1 - s_0
    if abs(step) < _NEAR:
        t = _tanh(0.5 * (s_0 + s_1))
        slope = 1.0 - t * t
        bend = -2.0 * t * slope
        third = (6.0 * t * t - 2.0) * slope
        mean = t + bend * step * step / 24.0
        return mean, 0.5 * slope + bend * step / 12.0 + third * step * step / 48.0
    mean = (_log_cosh(s_1) - area_0) / step
    return mean, (_tanh(s_1) - mean) / step


@compiled
def solve_gate(s_0: float, free: float, gain: float) -> tuple[float, float]:
    """Root s_1 of ``s_1 = free + gain * mean_gate(s_0, s_1)`` for gain < 2, and the mean there.

    Newton within a bracket; where its steps do not halve, bisection.
    """
    reach = abs(gain) + 1e-9 * (1.0 + abs(gain) + abs(free))  # a saturated gate's root lies inside
    low, high = free - reach, free + reach
    s_1, area_0 = free + gain * _tanh(s_0), _log_cosh(s_0)
    before = 2.0 * (high - low)
    mean = 0.0
    for _ in range(100):
        mean, slope = _mean_gate(s_0, area_0, s_1)
        residual = s_1 - free - gain * mean
        if residual > 0.0:
            high = s_1
        else:
            low = s_1
        step = -residual / (1.0 - gain * slope)
        if abs(step) <= 1e-10 * (1.0 + abs(s_1)):  # squared by the last step
            return s_1 + step, mean + slope * step
        if not low < s_1 + step < high or abs(step) > 0.5 * before:
            step = 0.5 * (low + high) - s_1
        s_1 += step
        before = abs(step)
    return s_1, mean


@compiled
def _march(
    phi: Array, drive: Array, ramp: Array, kick: Array, gamma: Array, n_sub: int, x: Array
) -> float:
    """Take n_sub substeps from x (n,), in place; returns Gamma x at the end.

    drive (n,): input at the start; ramp (n,): its growth per substep; kick (n,): effect of an
    open gate.
    """
    n = x.shape[0]
    free = np.empty(n)
    gain = s_0 = 0.0
    for i in range(n):
        gain += gamma[i] * kick[i]
        s_0 += gamma[i] * x[i]
    for k in range(n_sub):
        target = 0.0
        for i in range(n):
            free[i] = 0.0
            for j in range(n):
                now = drive[j] + k * ramp[j]
                free[i] += phi[0, i, j] * x[j] + phi[1, i, j] * now + phi[2, i, j] * ramp[j]
            target += gamma[i] * free[i]
        s_0, mean = solve_gate(s_0, target, gain)
        for i in range(n):
            x[i] = free[i] + kick[i] * mean
    return s_0


@compiled
def advance(
    size: Array, m_0: Array, m_1: Array, l_0: Array, l_1: Array, b: Array, gamma: Array,
    x: Array, y_0: Array, y_1: Array, rho: float, dt: float, n_sub: int, out: Array,
) -> float:  # fmt: skip
    """State out (n,) after dt [s] from x (n,), y (m,) going straight from y_0 to y_1, rho held.

    Matrices are in states divided by size (n,): M = m_0 + rho m_1 (n, n), L = l_0 + rho l_1 (n,
    m), b (n,) at rho = 1, gamma (n,). Returns Gamma x at the end.
    """
    h = dt / n_sub
    phi = phi_functions(h * (m_0 + rho * m_1))
    gain = h * (l_0 + rho * l_1)
    drive = _apply(gain, y_0)
    ramp = _apply(gain, (y_1 - y_0) / n_sub)
    kick = _apply(phi[1], h * rho * b)
    out[:] = x / size
    end = _march(phi, drive, ramp, kick, gamma, n_sub, out)
    out *= size
    return end
