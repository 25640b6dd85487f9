r"""Advances ``z' = M(rho) z + J(rho) y + b rho tanh(s)``, ``s = gamma z + feed y`` over one sample, compiled.

It serves every observer: unified, polytopic and gridding differ in their numbers only (`er_observers.law`).

The linear part is exact (phi functions of h M by scaling and doubling) for a y that goes straight
along each substep. Over the sample these straight lines join points of a parabola, ``y_0 + (y_1 -
y_0) th + bend (th^2 - th)``.
The gate enters with its mean over the straight line from s at the start to s at the end of a
substep,

.. math::  \bar\varphi = \frac{\ln\cosh s_1 - \ln\cosh s_0}{s_1 - s_0}

which integrates the passage through the steep part exactly, however few steps it takes, and keeps
the slope in [0, 1] that the certificate rests on. The end value solves one scalar equation,
monotone, by a bracketed Newton method.

Source: Hochbruck and Ostermann 2010 (phi functions); Quispel and McLaren 2008 (average vector
field).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from er_observers.observers.compiled import compiled

Array = NDArray[np.float64]

SUBSTEP = 1.25e-3
"""Longest substep [s]; the certificate shows that the discrete observer converges with it."""

_SLOTS = 2
"""Duties whose phi functions are remembered: one that stays, or two that alternate (Skyhook)."""
_TERMS = 13
_NEAR = 1e-2
_SATURATED = 20.0
_LN_2 = math.log(2.0)


def scratch_of(n: int) -> Array:
    """Room for one step of n states; remembers nothing yet."""
    return np.full(3 * n * n + 8 * n + _SLOTS * (2 + 3 * n * n), np.nan)


def substeps(dt: float) -> int:
    """Substeps for a sample of length dt [s]."""
    return max(1, math.ceil(dt / SUBSTEP - 1e-6))


@compiled
def _multiply(a: Array, b: Array, out: Array) -> None:
    """Product a b of square matrices (n, n) into out."""
    n = a.shape[0]
    for i in range(n):
        for j in range(n):
            out[i, j] = 0.0
        for k in range(n):
            factor = a[i, k]
            for j in range(n):
                out[i, j] += factor * b[k, j]


@compiled
def _apply(a: Array, x: Array, out: Array) -> None:
    """Product a x, (n, m) times (m,), into out."""
    for i in range(a.shape[0]):
        total = 0.0
        for j in range(a.shape[1]):
            total += a[i, j] * x[j]
        out[i] = total


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
def fill_phi(m: Array, phi: Array, square: Array, product: Array) -> None:
    """Fill phi (3, n, n) with phi_0 = exp(m), phi_1 and phi_2 of m (n, n), which is scaled in place."""
    n = m.shape[0]
    norm = 0.0
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += abs(m[i, j])
        norm = max(norm, total)
    doublings, scale = 0, 1.0
    while norm * scale > 1.0 and doublings < 60:
        scale *= 0.5
        doublings += 1
    for i in range(n):
        for j in range(n):
            m[i, j] *= scale
    _small_phi(m, phi, product)
    for _ in range(doublings):
        _double_phi(phi, square, product)


@compiled
def phi_functions(m: Array) -> Array:
    """The three matrices (3, n, n) phi_0 = exp(m), phi_1 and phi_2 of m (n, n), in memory of their own."""
    n = m.shape[0]
    phi, room = np.empty((3, n, n)), np.empty((3, n, n))
    room[2] = m
    fill_phi(room[2], phi, room[0], room[1])
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
    phi: Array, steady: Array, ramp: Array, level: Array, slant: Array, kick: Array, gamma: Array,
    start: float, rise: float, hump: float, n_sub: int, free: Array, x: Array,
) -> float:  # fmt: skip
    """Take n_sub substeps from x (n,), in place; returns the gate's input at the end.

    steady (n,): effect of the input during the first substep; ramp (n,): what it grows by from one
    to the next; level, slant (n,): effect of a bend of one that stays and that grows by one; kick
    (n,): effect of an open gate. start, rise, hump: what the outputs add to the gate's input at the
    start, per substep and by their bend.
    """
    n = x.shape[0]
    gain, s_0 = 0.0, start
    for i in range(n):
        gain += gamma[i] * kick[i]
        s_0 += gamma[i] * x[i]
    for k in range(n_sub):
        here, there = k / n_sub, (k + 1) / n_sub
        low, high = here * here - here, there * there - there
        target = start + (k + 1) * rise + high * hump
        for i in range(n):
            total = steady[i] + k * ramp[i] + low * level[i] + (high - low) * slant[i]
            for j in range(n):
                total += phi[0, i, j] * x[j]
            free[i] = total
            target += gamma[i] * total
        s_0, gate = solve_gate(s_0, target, gain)
        for i in range(n):
            x[i] = free[i] + kick[i] * gate
    return s_0


@compiled
def _blend(rho: float, nodes: Array, values: Array, factor: float, out: Array) -> None:
    """Into out (...,): factor times values (K, ...) on the straight line between nodes (K,)."""
    k = 0
    while k < nodes.shape[0] - 2 and rho > nodes[k + 1]:
        k += 1
    high = min(max((rho - nodes[k]) / (nodes[k + 1] - nodes[k]), 0.0), 1.0)
    low = factor * (1.0 - high)
    high *= factor
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            out[i, j] = low * values[k, i, j] + high * values[k + 1, i, j]


@compiled
def _parts(
    shape: tuple[int, int, int], values: Array
) -> tuple[Array, Array, Array, Array, Array, Array, Array]:
    """rho, M, J, b, gamma, feed, size of a `matrices.Plan`, as views."""
    n, m, k = shape
    at = k + k * n * (n + m)
    return (
        values[:k],
        values[k : k + k * n * n].reshape((k, n, n)),
        values[k + k * n * n : at].reshape((k, n, m)),
        values[at : at + n],
        values[at + n : at + 2 * n],
        values[at + 2 * n : at + 2 * n + m],
        values[at + 2 * n + m :],
    )


@compiled
def _room(n: int, scratch: Array) -> tuple[Array, Array, Array]:
    """Views of the scratch: three matrices, eight vectors, what is remembered (`_SLOTS`, 2 + 3 n n)."""
    a, b = 3 * n * n, 3 * n * n + 8 * n
    return (
        scratch[:a].reshape((3, n, n)),
        scratch[a:b].reshape((8, n)),
        scratch[b:].reshape((_SLOTS, 2 + a)),
    )


@compiled
def _remembered(kept: Array, rho: float, h: float) -> int:
    """Row of `kept` that holds phi of this duty and step; -1 for none. Comparisons with NaN are false."""
    for k in range(kept.shape[0]):
        if kept[k, 0] == rho and kept[k, 1] == h:
            return k
    return -1


@compiled
def _oldest(kept: Array, rho: float, h: float) -> int:
    """Row for phi of another duty: the last one, after the others have moved up."""
    for k in range(kept.shape[0] - 1):
        kept[k] = kept[k + 1]
    last = int(kept.shape[0]) - 1
    kept[last, 0], kept[last, 1] = rho, h
    return last


@compiled
def _inputs(gain: Array, y_0: Array, y_1: Array, n_sub: int, drive: Array, slope: Array) -> None:
    """Into drive (n,) and slope (n,): effect of the outputs at the start, and its growth per substep."""
    for i in range(drive.shape[0]):
        drive[i] = slope[i] = 0.0
        for j in range(y_0.shape[0]):
            drive[i] += gain[i, j] * y_0[j]
            slope[i] += gain[i, j] * (y_1[j] - y_0[j]) / n_sub


@compiled
def advance(
    shape: tuple[int, int, int], values: Array, scratch: Array,
    z: Array, y_0: Array, y_1: Array, bend: Array, rho: float, dt: float, n_sub: int, out: Array,
) -> float:  # fmt: skip
    """State out (N,) after dt [s] from z (N,), y (m,) going from y_0 to y_1 with a bend (m,), rho held.

    shape, values, scratch: a `matrices.Plan`. Returns the gate's input at the end. Asks for no
    memory.
    """
    n, m, _ = shape
    nodes, m_nodes, j_nodes, b, gamma, feed, size = _parts(shape, values)
    more, rows, kept = _room(n, scratch)
    square, product, whole = more[0], more[1], more[2]
    drive, slope, kick, free, steady, ramp = rows[0], rows[1], rows[2], rows[3], rows[4], rows[5]
    level, slant = rows[6], rows[7]
    h = dt / n_sub
    gain = square[:, :m]
    _blend(rho, nodes, j_nodes, h, gain)
    _inputs(gain, y_0, y_1, n_sub, drive, slope)
    _apply(gain, bend, kick)
    row = _remembered(kept, rho, h)
    known = row >= 0
    if not known:
        row = _oldest(kept, rho, h)
    phi = kept[row, 2:].reshape((3, n, n))
    if not known:
        _blend(rho, nodes, m_nodes, h, whole)
        fill_phi(whole, phi, square, product)
    _apply(phi[1], drive, steady)
    _apply(phi[1], slope, ramp)
    _apply(phi[2], slope, free)
    _apply(phi[1], kick, level)
    _apply(phi[2], kick, slant)
    start = rise = hump = 0.0
    for j in range(m):
        hump += feed[j] * bend[j]
        start += feed[j] * y_0[j]
        rise += feed[j] * (y_1[j] - y_0[j]) / n_sub
    for i in range(n):
        steady[i] += free[i]
        drive[i] = h * rho * b[i]
        out[i] = z[i] / size[i]
    _apply(phi[1], drive, kick)
    s_1 = _march(phi, steady, ramp, level, slant, kick, gamma, start, rise, hump, n_sub, free, out)
    for i in range(n):
        out[i] *= size[i]
    return s_1
