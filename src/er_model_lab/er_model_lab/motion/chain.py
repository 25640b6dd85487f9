"""The motion as a chain of integrators: its Kalman filter and smoother, compiled.

The state is [x, v, a, j, b], and u behind it where the velocity channel lags; see `fuse` for what they mean. A sample
later a state of the chain has moved by those after it, and u by the whole chain.

Source: Rauch, Tung and Striebel 1965; Kalman 1960.
"""

from __future__ import annotations

import math

import numpy as np
from er_models.cache.compiled import on_disk
from er_models.model import Array
from numpy.typing import NDArray

STATES, LAGGING = 5, 6
"""States of the motion, and with that of a velocity channel that lags."""
CHAIN = 4
"""Those of the longest chain; of a shorter one the last stays zero, and so does what leans on it."""
States = tuple[float, ...]
"""One number for each state: how many there are is known where this is compiled, which is twice as fast."""
_SETTLED = 8
"""Sample from which on innovations tell the noise, not the unknown state at the first one."""

_EXACT = 1e-15
"""Share of a variance below which what is left of it is rounding."""

compiled = on_disk(nogil=True, error_model="numpy")


@compiled
def ramps(s: float, lag: float, out: Array) -> float:
    """Answer of T u' + u = v at time s to v = 1, s and s^2 / 2, in out (3,); and what is left of u."""
    left = math.exp(-s / lag)
    out[0] = 1.0 - left
    out[1] = s - lag * out[0]
    out[2] = s**2 / 2.0 - lag * out[1]
    return left


@compiled
def transition(dt: float, order: int, lag: float, m: int) -> Array:
    """Transition matrix (m, m) over one sample of a chain of that order, lagging where m is `LAGGING`."""
    f = np.eye(m)
    f[0, 1] = f[1, 2] = dt
    f[0, 2] = dt**2 / 2.0
    if order == 4:
        f[2, 3] = dt
        f[1, 3] = dt**2 / 2.0
        f[0, 3] = dt**3 / 6.0
    if m == LAGGING:
        to = np.zeros(3)
        f[5, 5] = ramps(dt, lag, to)
        for i in range(order - 1):
            f[5, 1 + i] = to[i]
    return f


@compiled
def diffusion(dt: float, order: int, lag: float, m: int) -> Array:
    """Covariance (m, m) that white noise of unit intensity at the end of the chain adds over one sample.

    Gauss-Legendre with five points: exact for the chain, and to 3e-5 for a lag of a tenth of a sample.
    """
    nodes = (-0.906179845938664, -0.538469310105683, 0.0, 0.538469310105683, 0.906179845938664)
    weights = (
        0.236926885056189,
        0.478628670499366,
        0.568888888888889,
        0.478628670499366,
        0.236926885056189,
    )
    q, g, to = np.zeros((m, m)), np.zeros(m), np.zeros(3)
    for k in range(5):
        s = 0.5 * dt * (1.0 + nodes[k])
        power = 1.0
        for i in range(order):
            g[order - 1 - i] = power
            power *= s / (i + 1.0)
        if m == LAGGING:
            ramps(s, lag, to)
            g[5] = to[order - 2]
        for i in range(m):
            for j in range(m):
                q[i, j] += 0.5 * dt * weights[k] * g[i] * g[j]
    return q


@compiled
def _carry(f: Array, states: States, a: Array) -> None:
    """F a in place, for a (m, m): what leans on others goes before them, the lagging state before the chain."""
    m = len(states)
    if m == LAGGING:
        for j in range(m):
            a[5, j] *= f[5, 5]
        for k in range(1, CHAIN):
            for j in range(m):
                a[5, j] += f[5, k] * a[k, j]
    for i in range(CHAIN - 1):
        for k in range(i + 1, CHAIN):
            for j in range(m):
                a[i, j] += f[i, k] * a[k, j]


@compiled
def _move(f: Array, states: States, x: Array) -> None:
    """F x in place, for x (m,), as `_carry`."""
    if len(states) == LAGGING:
        x[5] *= f[5, 5]
        for k in range(1, CHAIN):
            x[5] += f[5, k] * x[k]
    for i in range(CHAIN - 1):
        for k in range(i + 1, CHAIN):
            x[i] += f[i, k] * x[k]


@compiled
def _advance(f: Array, states: States, d: Array, drive: float, x: Array, p: Array) -> None:
    """Bring state x (m,) and covariance p (m, m) over one sample, F x and F p F' + drive d, in place."""
    m = len(states)
    _move(f, states, x)
    _carry(f, states, p)
    _carry(f, states, p.T)
    for i in range(m):
        for j in range(m):
            p[i, j] += drive * d[i, j]


@compiled
def _gain_of(p: Array, states: States, h: Array, r: float, gain: Array) -> float:
    """Innovation variance and gain (m,) of one scalar measurement with row h (m,) and variance r."""
    m, s = len(states), r
    for i in range(m):
        total = 0.0
        for j in range(m):
            total += p[i, j] * h[j]
        gain[i] = total
        s += h[i] * total
    for i in range(m):
        gain[i] /= s
    return s


@compiled
def _store(k: int, x: Array, p: Array, xs: Array, ps: Array) -> None:
    """Keep state and covariance of sample k, where they are wanted."""
    if k < xs.shape[0]:
        for i in range(x.shape[0]):
            xs[k, i] = x[i]
            for j in range(x.shape[0]):
                ps[k, i, j] = p[i, j]


@compiled
def filtered(
    dt: float, order: int, lag: float, zs: Array, seen: NDArray[np.uint8], rows: Array, variances: Array, drive: float,
    activity: Array, spread: States, xs: Array, ps: Array, xp: Array, pp: Array,
) -> float:  # fmt: skip
    """Kalman filter over measurements (n, 3), one channel after the other; returns the log likelihood.

    seen (n, 3): which of them there are;
    rows (3, m): what of the state each channel shows, variances (3,) of its noise; drive, activity (n,): intensity of
    the noise at the end of the chain; spread (m): variance of the first state. Filled: state and covariance of each
    sample after its measurements (xs, ps) and before them (xp, pp), where these arrays hold samples.
    """
    m = len(spread)
    f, d = transition(dt, order, lag, m), diffusion(dt, order, lag, m)
    x, p, gain = np.zeros(m), np.zeros((m, m)), np.zeros(m)
    for i in range(m):
        p[i, i] = spread[i]
    likelihood = 0.0
    for k in range(zs.shape[0]):
        if k > 0:
            _advance(f, spread, d, drive * activity[k], x, p)
        _store(k, x, p, xp, pp)
        for c in range(3):
            if not seen[k, c]:
                continue
            h, e = rows[c], zs[k, c]
            s = _gain_of(p, spread, h, variances[c], gain)
            for i in range(m):
                e -= h[i] * x[i]
            if k >= _SETTLED:
                likelihood -= 0.5 * (np.log(s) + e * e / s)
            for i in range(m):
                x[i] += gain[i] * e
                for j in range(i, m):
                    p[i, j] -= gain[i] * gain[j] * s
                    p[j, i] = p[i, j]
        _store(k, x, p, xs, ps)
    return likelihood


@compiled
def _root_of(p: Array, states: States, root: Array) -> None:
    """Cholesky factor of a covariance p (m, m) in root; a state that is known exactly gets a column of zeros."""
    m = len(states)
    for j in range(m):
        for i in range(j, m):
            rest = p[i, j]
            for k in range(j):
                rest -= root[i, k] * root[j, k]
            if i == j:
                root[j, j] = np.sqrt(rest) if rest > _EXACT * p[j, j] else 0.0
            else:
                root[i, j] = rest / root[j, j] if root[j, j] > 0.0 else 0.0


@compiled
def _divide(root: Array, states: States, a: Array) -> None:
    """p^-1 a in place for p = root root' and a (m, m)."""
    m = len(states)
    for j in range(m):
        for i in range(m):
            for k in range(i):
                a[i, j] -= root[i, k] * a[k, j]
            a[i, j] = a[i, j] / root[i, i] if root[i, i] > 0.0 else 0.0
        for i in range(m - 1, -1, -1):
            for k in range(i + 1, m):
                a[i, j] -= root[k, i] * a[k, j]
            a[i, j] = a[i, j] / root[i, i] if root[i, i] > 0.0 else 0.0


@compiled
def _hear(share: Array, states: States, by: Array, x: Array, p: Array, lean: Array) -> None:
    """What the next sample tells this one, x += share' by[0] and p += share' by[1:] share, in place."""
    m = len(states)
    for i in range(m):
        for j in range(m):
            x[i] += share[j, i] * by[0, j]
            lean[i, j] = 0.0
            for k in range(m):
                lean[i, j] += by[1 + i, k] * share[k, j]
    for i in range(m):
        for j in range(m):
            for k in range(m):
                p[i, j] += share[k, i] * lean[k, j]


@compiled
def smoothed(
    dt: float, order: int, lag: float, states: States, xs: Array, ps: Array, xp: Array, pp: Array
) -> None:  # fmt: skip
    """Rauch-Tung-Striebel backward pass over what `filtered` has filled, in place in xs and ps.

    states (m): any numbers.
    """
    n, m = xs.shape[0], len(states)
    f = transition(dt, order, lag, m)
    root, share, lean, by = (
        np.zeros((m, m)),
        np.zeros((m, m)),
        np.zeros((m, m)),
        np.zeros((m + 1, m)),
    )
    for k in range(n - 2, -1, -1):
        for i in range(m):
            by[0, i] = xs[k + 1, i] - xp[k + 1, i]
            for j in range(m):
                share[i, j] = ps[k, i, j]
                by[1 + i, j] = ps[k + 1, i, j] - pp[k + 1, i, j]
        _carry(f, states, share)
        _root_of(pp[k + 1], states, root)
        _divide(root, states, share)
        _hear(share, states, by, xs[k], ps[k], lean)
