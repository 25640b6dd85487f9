r"""Follows car and damper through the samples, and makes of each what it says of the unknowns, compiled.

An iterated Kalman filter of the state of `passage`, whose road may do anything from sample to sample: the wheel's
sensor tells it. What body (or a given force), deflection and velocity show beyond what was expected are innovations,
which err on their own; their derivatives by the unknowns, the filter's own answers included, are the rows of the
regression. Where what is believed may be far off, a loose filter goes by the sensors more than by the model.

Source: Ljung 1979 (recursive prediction error method); Bell and Cathey 1993 (iterated filter); Kalman 1960.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from er_models.model import Array

from er_observers.faults.passage import (
    BODY,
    COLUMNS,
    F_ER,
    FIELD,
    LAW,
    OFFSET,
    PER_MASS,
    RAMP,
    SLOPE,
    STATES,
    STIFF,
    TURNED,
    VISCOUS,
    R,
    V,
    W,
    X,
    prescribe,
    sample,
    strut,
)
from er_observers.faults.regression import C1, K_S, M_S, M_US, SIGMA
from er_observers.faults.sums import N
from er_observers.observers.compiled import compiled
from er_observers.observers.copies import add_row, copy, copy_row, difference

BODY_SEEN, WHEEL_SEEN, X_SEEN, V_SEEN, FORCE_SEEN = range(5)
"""Places in what is seen (5,): accelerations [m/s2], deflection, velocity, and a given force; NaN where it is not."""
SEEN = 5
STATE, COVARIANCE, LEAN = slice(0, 5), slice(5, 30), slice(30, 30 + STATES * N)
BENDS = 3
BENT = slice(LEAN.stop, LEAN.stop + STATES * BENDS)
BEFORE, CHANGE, ROUGH, UNDER_WAY = range(BENT.stop, BENT.stop + 4)
SIZE = UNDER_WAY + 1
"""A follower (SIZE,): state (5,), covariance (5, 5), how the state leans on the unknowns (5, N) and on the bends of the
road (5, 3), the acceleration of the body that was seen last [m/s2], the last change of the road's rate from sample to
sample [m/s], the mean square of these changes of late [m2/s2], and 1 once there was one."""
ROW = N + 2 + BENDS
"""A row: derivative of an innovation by the unknowns (N,), the innovation, its variance (0: nothing was seen), and its
derivatives by both shares of the bend and by what is left of it, in its deviations."""
ROAD = 3
"""Place in the noise (4,), after those of acceleration, x and v: how much the road's rate may be [m/s]."""
_ITERATIONS, _CLOSE = 4, 0.1
"""Most passes over a sample, and the move of the gate's argument below which no further one is made."""
_WIDE = 1e4
"""Deviation of the tyre's pull at the start, over the noise of an accelerometer."""
_ALSO = 0.3
"""Share of `loose` by which the yield force may be wrong as well."""
_LATE = 0.25
"""Share of a sample in the mean square of changes."""


class Rig(NamedTuple):
    """A car with its sensors.

    p (11,): see `regression`; noise (4,): see `ROAD`; force_noise [N]: of a given force, 0 where the body's
    acceleration tells it.
    """

    p: Array
    noise: Array
    force_noise: float


class Belief(NamedTuple):
    """What a sample is followed with.

    known (N,): the unknowns; loose [N]: force by which they may be wrong; bends (3,): how far the road's rate goes on
    within a sample as it did since the one before, and as its change did, 1 for a smooth road and 0 for one that is
    straight between samples, and how far it does something else, over its changes of late.
    """

    known: Array
    loose: float
    bends: Array


class Step(NamedTuple):
    """A sample: what is seen at its end (SEEN,), the duty during it, its length [s]."""

    seen: Array
    duty: float
    dt: float


@compiled
def begin(p: Array, noise: Array, x: float, v: float, mind: Array) -> None:
    """Start a follower with a first x and v (NaN: unknown); the field may be anything."""
    known = math.isfinite(v)
    mind[:] = 0.0
    z, P = mind[STATE], mind[COVARIANCE].reshape((STATES, STATES))
    z[X], z[V] = x, v if known else 0.0
    P[X, X], P[V, V] = noise[1] ** 2, noise[2] ** 2 if known else 1e6 * noise[2] ** 2
    P[F_ER, F_ER], P[W, W] = (0.3 * p[SIGMA]) ** 2, (_WIDE * noise[0]) ** 2


@compiled
def advance(rig: Rig, belief: Belief, step: Step, mind: Array, rows: Array) -> None:
    """Follow one sample, in place, with what is believed; fill rows (3, ROW)."""
    p, known, given = rig.p, belief.known, rig.force_noise > 0.0
    z, P = mind[STATE], mind[COVARIANCE].reshape((STATES, STATES))
    S, before = mind[LEAN].reshape((STATES, N)), z[R]
    B, bend = mind[BENT].reshape((STATES, BENDS)), _bend(belief.bends, before, mind)
    law, turn = np.empty(LAW), np.empty((N, TURNED))
    prescribe(p, known, step.duty, step.dt, _push(step.seen, given, mind), law, turn)
    _free_the_road(rig.noise, P, S)
    measured, r = np.empty(4), np.empty(4)
    _look(rig, step.seen, belief.loose, measured, r)
    at, end, rest = z.copy(), np.empty(STATES), np.empty(STATES)
    T = np.empty((STATES, COLUMNS + N))
    H, shown = np.zeros((4, STATES)), np.empty(4)
    whole = T.shape[1]  # a bare number is a type to Numba: it would be a compilation of its own
    for _ in range(_ITERATIONS):
        _pass(law, turn, bend, step.dt, at, end, T, whole - N)
        _show(p, law, known, end, given, H, shown)
        difference(z, at, rest)
        move = _improved(P, T, H, shown, measured, r, rest)
        add_row(move, at)
        if abs(p[C1] * (T[V, :STATES] @ move)) < _CLOSE:
            break
    copy(S, T[:, COLUMNS:])
    _pass(law, turn, bend, step.dt, at, end, T, whole)
    _show(p, law, known, end, given, H, shown)
    A = np.ascontiguousarray(T[:, :STATES])
    copy(A @ P @ A.T, P)
    copy(A @ B, B)
    _widen(law, belief, step.dt, at[R] - before, T[:, RAMP], mind, P, B)
    copy(T[:, COLUMNS:], S)
    difference(z, at, rest)
    rest = A @ rest
    for q in range(4):
        _correct(p, q, turn, given, end, H[q], measured[q] - shown[q], r[q], P, S, B, rest, rows)
    copy_row(end, z)
    add_row(rest, z)
    _even_out(P)


@compiled
def _push(seen: Array, given: bool, mind: Array) -> float:
    """Acceleration of the body during a sample [m/s2] for `prescribe`, NaN where f tells it; the last one is kept."""
    now = seen[BODY_SEEN] if math.isfinite(seen[BODY_SEEN]) else mind[BEFORE]
    push = 0.5 * (mind[BEFORE] + now) if given else math.nan
    mind[BEFORE] = now
    return float(push)


@compiled
def _free_the_road(noise: Array, P: Array, S: Array) -> None:
    """Let the road's rate be anything, whatever it was, in place: covariance P (5, 5), leanings S (5, N)."""
    P[R, :] = 0.0
    P[:, R] = 0.0
    P[R, R] = noise[ROAD] ** 2
    S[R, :] = 0.0


@compiled
def _look(rig: Rig, seen: Array, loose: float, measured: Array, r: Array) -> None:
    """Fill what wheel, x, v and body (or force) measured (4,), NaN for nothing, and its deviations r (4,)."""
    given = rig.force_noise > 0.0
    r[0], r[1], r[2] = rig.noise[0], rig.noise[1], rig.noise[2]
    r[3] = rig.force_noise if given else rig.noise[0]
    r[3] = math.hypot(r[3], loose if given else loose / rig.p[M_S])
    measured[0], measured[1], measured[2] = seen[WHEEL_SEEN], seen[X_SEEN], seen[V_SEEN]
    measured[3] = seen[FORCE_SEEN] if given else seen[BODY_SEEN]


@compiled
def _bend(bends: Array, before: float, mind: Array) -> tuple[float, float]:
    """By how much the road's rate changes within a sample: its derivative by the mean rate, and what it is at 0 [m/s].

    before: mean rate of the sample before [m/s].
    """
    if mind[UNDER_WAY] <= 0.0:
        return 0.0, 0.0
    by = bends[0] + 0.5 * bends[1]
    return by, -by * before - 0.5 * bends[1] * mind[CHANGE]


@compiled
def _widen(
    law: Array,
    belief: Belief,
    dt: float,
    change: float,
    ramp: Array,
    mind: Array,
    P: Array,
    B: Array,
) -> None:
    """Add to P (5, 5), in place, what a loose belief and the rest of a bend may do, and to B (5, 3) what bends do.

    change: of the road's rate [m/s]; ramp (5,): what a slope of it does to the end of the sample.
    """
    P[V, V] += (0.5 * dt * law[PER_MASS] * belief.loose) ** 2
    P[F_ER, F_ER] += (_ALSO * belief.loose) ** 2
    mind[ROUGH] += _LATE * (change * change - mind[ROUGH])
    rest = belief.bends[2] * math.sqrt(mind[ROUGH]) / dt
    known, second = mind[UNDER_WAY] > 0.0, change - mind[CHANGE]
    for i in range(STATES):
        for j in range(STATES):
            P[i, j] += rest * rest * ramp[i] * ramp[j]
        B[i, 2] = rest * ramp[i]
        if known:
            B[i, 0] += change / dt * ramp[i]
            B[i, 1] += 0.5 * second / dt * ramp[i]
    mind[CHANGE], mind[UNDER_WAY] = change, 1.0


@compiled
def _even_out(P: Array) -> None:
    """Make P (5, 5) symmetric, in place."""
    for i in range(STATES):
        for j in range(i):
            P[i, j] = P[j, i] = 0.5 * (P[i, j] + P[j, i])


@compiled
def _pass(
    law: Array,
    turn: Array,
    bend: tuple[float, float],
    dt: float,
    at: Array,
    end: Array,
    T: Array,
    columns: int,
) -> None:
    """State at the end of a sample of dt [s] that begins at `at`, at[R] the mean rate of its road, and derivatives."""
    by, fixed = bend
    change = by * at[R] + fixed
    T[:, :COLUMNS] = 0.0
    for i in range(STATES):
        T[i, i] = 1.0
    T[R, RAMP] = -0.5 * dt
    copy_row(at, end)
    end[R] -= 0.5 * change
    law[SLOPE] = change / dt
    sample(law, turn, end, T, columns)
    end[R] -= 0.5 * change
    T[R, RAMP] -= 0.5 * dt
    for i in range(STATES):
        T[i, R] += by / dt * T[i, RAMP]


@compiled
def _show(
    p: Array, law: Array, known: Array, z: Array, given: bool, H: Array, shown: Array
) -> None:
    """What the sensors of wheel, x, v and body (or force) should show, (4,), and its derivatives H (4, 5)."""
    f = strut(law, z)
    H[0, X], H[0, V], H[0, F_ER] = (
        law[STIFF] / p[M_US],
        law[VISCOUS] / p[M_US],
        law[FIELD] / p[M_US],
    )
    H[0, W] = H[1, X] = H[2, V] = 1.0
    shown[0], shown[1], shown[2] = f / p[M_US] + z[W], z[X], z[V]
    spring = p[K_S] * (1.0 + known[3])
    if given:
        H[3, X], H[3, V], H[3, F_ER] = law[STIFF] - spring, law[VISCOUS], law[FIELD]
        shown[3] = f - spring * z[X]
    else:
        by = -law[BODY]
        H[3, X], H[3, V], H[3, F_ER] = by * law[STIFF], by * law[VISCOUS], by * law[FIELD]
        shown[3] = by * f


@compiled
def _improved(
    P: Array, T: Array, H: Array, shown: Array, measured: Array, r: Array, rest: Array
) -> Array:
    """How far the state at the begin of a sample should move, (5,), for what its end shows; rest: its mean less it."""
    move, Q, h = rest.copy(), P.copy(), np.empty(STATES)
    for q in range(4):
        if not math.isfinite(measured[q]):
            continue
        for j in range(STATES):
            h[j] = H[q, 0] * T[0, j] + H[q, 1] * T[1, j] + H[q, 2] * T[2, j] + H[q, 3] * T[3, j]
        g = Q @ h
        spread = h @ g + r[q] ** 2
        error = (measured[q] - shown[q] - h @ move) / spread
        for i in range(STATES):
            move[i] += g[i] * error
            for j in range(STATES):
                Q[i, j] -= g[i] * g[j] / spread
    return move


@compiled
def _lean(h: Array, S: Array, phi: Array) -> None:
    """Fill phi (n,) with how a sensor leans on what the state leans on by S (5, n)."""
    for i in range(phi.size):
        phi[i] = 0.0
        for j in range(STATES):
            phi[i] += h[j] * S[j, i]


@compiled
def _turn(p: Array, q: int, turn: Array, given: bool, z: Array, phi: Array) -> None:
    """Add, in place, what the unknowns change in the force that a sensor feels."""
    for i in range(N):
        f = turn[i, STIFF] * z[X] + turn[i, VISCOUS] * z[V] + turn[i, FIELD] * z[F_ER]
        f += turn[i, OFFSET]
        if q == 0:
            phi[i] += f / p[M_US]
        elif given:
            phi[i] += f if i != 3 else 0.0
        else:
            phi[i] -= f / p[M_S]


@compiled
def _correct(
    p: Array, q: int, turn: Array, given: bool, z: Array, h: Array, error: float, noise: float,
    P: Array, S: Array, B: Array, rest: Array, rows: Array,
) -> None:  # fmt: skip
    """Correct by one sensor, in place; all but the wheel's, which tells the road, leave a row."""
    if q > 0:
        rows[q - 1, N + 1] = 0.0
    if not math.isfinite(error):
        return
    g, phi, bent = P @ h, np.empty(N), np.empty(BENDS)
    spread = h @ g + noise**2
    error -= float(h @ rest)
    _lean(h, S, phi)
    _lean(h, B, bent)
    if q in (0, 3):
        _turn(p, q, turn, given, z, phi)
    if q > 0:
        copy_row(phi, rows[q - 1, :N])
        rows[q - 1, N], rows[q - 1, N + 1] = error, spread
        copy_row(bent, rows[q - 1, N + 2 :])
    for i in range(STATES):
        share = g[i] / spread
        rest[i] += share * error
        for j in range(N):
            S[i, j] -= share * phi[j]
        for j in range(BENDS):
            B[i, j] -= share * bent[j]
        for j in range(STATES):
            P[i, j] -= share * g[j]
