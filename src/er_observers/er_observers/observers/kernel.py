r"""Advances ``z' = M(rho) z + J(rho) y + b rho tanh(s)``, ``s = gamma z + feed y`` over one sample, compiled.

It serves every observer: unified, polytopic and gridding differ in their numbers only (`er_observers.law`).

Over a sample y follows a parabola, ``y_0 + (y_1 - y_0) th + bend (th^2 - th)``, in straight lines from
one substep to the next. Along each the linear part is exact, and the gate enters with its mean over
the straight line from s at the start to s at the end (`gate`). What a substep does is one matrix,
``[z, y, change of y, rho times mean gate] -> z`` (`substep`): looked up over the duty where it has the
usual length, else made.
"""

from __future__ import annotations

import math

import numpy as np
from er_models.model import Array

from er_observers.observers.compiled import compiled
from er_observers.observers.gate import gate_of, solve_gate
from er_observers.observers.substep import look_up, made, room_of

SUBSTEP = 1.25e-3
"""Longest substep [s], the usual one; the certificate shows that the discrete observer converges with it."""

HEAD = 4
"""Numbers at the head of a plan: states N, outputs m, duties of the law K, duties of the table."""
_ROUNDING = 1e-9
"""Share of a substep that makes no other length."""


def scratch_of(n: int, m: int) -> Array:
    """Room for one sample of n states and m outputs; remembers nothing yet."""
    return np.full((n + 1) * (n + 2 * m + 1) + room_of(n, m), np.nan)


def substeps(dt: float) -> int:
    """Substeps for a sample of length dt [s]."""
    return max(1, math.ceil(dt / SUBSTEP - 1e-6))


@compiled
def _march(
    step: Array, gamma: Array, feed: Array, y_0: Array, y_1: Array, bend: Array, rho: float,
    n_sub: int, w: Array, x: Array, extra: float,
) -> float:  # fmt: skip
    """Take n_sub substeps from x (N,), in place; returns the gate's input at the end.

    step (N, N + 2 m + 1): of `substep`; w (N + 2 m): room for what it is applied to, without the gate.
    """
    n, m = x.shape[0], y_0.shape[0]
    last = n + 2 * m
    s = gain = 0.0
    for i in range(n):
        s += gamma[i] * x[i]
        gain += gamma[i] * step[i, last]
        w[i] = x[i]
    for j in range(m):
        s += feed[j] * y_0[j]
        w[n + j] = y_0[j]
    shift = gain * extra
    gain *= rho
    t, area = gate_of(s)
    for k in range(1, n_sub + 1):
        share = k / n_sub
        free = shift
        for j in range(m):
            y = y_0[j] + share * (y_1[j] - y_0[j]) + (share * share - share) * bend[j]
            w[n + m + j] = y - w[n + j]
            free += feed[j] * y
        for i in range(n):
            total = 0.0
            for j in range(last):
                total += step[i, j] * w[j]
            x[i] = total
            free += gamma[i] * total
        s, t, area, gate = solve_gate(s, t, area, free, gain)
        gate = gate * rho + extra
        for i in range(n):
            x[i] += gate * step[i, last]
            w[i] = x[i]
        for j in range(m):
            w[n + j] += w[n + m + j]
    return s


@compiled
def advance(
    values: Array, scratch: Array, z: Array, y_0: Array, y_1: Array, bend: Array, rho: float,
    dt: float, n_sub: int, out: Array, extra: float,
) -> float:  # fmt: skip
    """State out (N,) after dt [s] from z (N,), y (m,) going from y_0 to y_1 with a bend (m,), rho held.

    extra: what acts beside rho times the gate, as it does. values, scratch: a `matrices.Plan`.
    Returns the gate's input at the end. Asks for no memory.
    """
    n, m = z.shape[0], y_0.shape[0]
    width, law, table = n + 2 * m + 1, int(values[2]), int(values[3])
    head, at, h = HEAD + n, HEAD + 2 * n + m, dt / n_sub
    size, w = values[head : head + n], scratch[: width - 1]
    if abs(h - SUBSTEP) <= _ROUNDING * SUBSTEP:
        row = scratch[width : width + n * width]
        look_up(rho, values[at : at + table], values[at + table :], row)
    else:
        rest = at + table * (1 + n * width)
        row = made(values[rest:], law, n, m, rho, h, scratch[width + n * width :])
    for i in range(n):
        out[i] = z[i] / size[i]
    gamma, feed, step = values[HEAD:head], values[head + n : at], row.reshape((n, width))
    s = _march(step, gamma, feed, y_0, y_1, bend, rho, n_sub, w, out, extra)
    for i in range(n):
        out[i] *= size[i]
    return s
