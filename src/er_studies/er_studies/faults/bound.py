r"""How well any unbiased estimator could know the factors: the Cramer-Rao bound of a drive, with every sensor's noise.

The motion and fluid :math:`[x, v, F_{er}]`, the factors f_1, f_2, f_3 and relative errors of the model obey

.. math::  \dot v = -(k_s x + F_d + b)/m_s - \ddot z_{us}, \quad
           \tau \dot F_{er} = \sigma u^\beta \tanh(k_1 x + c_1 v) - F_{er}

with F_d of (6.8). The wheel's acceleration may be any, its sensor tells it; the sprung accelerometer shows the first
term, the deflection sensor x and v. Linearised along the true motion, the covariance of a Kalman filter is the inverse
of the Fisher information. It is told when the fault appears and which factors it may concern.

Source: Kay 1993 (3.9), 1998 (detection); Tichavsky, Muravchik and Nehorai 1998 (recursive bound); thesis (2.10), (6.8).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from er_models.constants import SAMPLE_TIME as DT
from er_models.model import Array
from er_observers.faults.regression import BETA, C0, C1, K0, K1, K_S, M_S, SIGMA, TAU
from er_observers.faults.rules import Estimator
from er_observers.faults.sums import TRIANGLE, N

from er_studies.faults.trials import Drive

NAMES = ("f1", "f2", "f3")
X, V, F, F1, F2, F3, E_K0, E_C0, E_SIGMA, E_KS, OFFSET, E_TAU, E_K1, E_C1 = range(14)
"""Places in the state: motion, fluid, factors, and the unknowns of `regression` in their order."""
SIZE = 14
_PARTS = 4
_ANY = 1.0
"""Deviation of a factor that may be anything."""


def covariances(
    p: Estimator, record: Drive, left: Mapping[str, float], news: Sequence[Sequence[str]], begun: int,
    until: Sequence[int], *, certain: bool = False,
) -> Array:  # fmt: skip
    """Least covariances (len(news), len(until), 3, 3) of f1, f2, f3 after these numbers of samples.

    left: true factors from the sample `begun` on. news: factors that may have changed then, the others being known;
    one bound for each. certain: the healthy damper is known exactly; otherwise it is believed within the estimator's
    tolerance at first, and learnt from the samples before the fault.
    """
    P = np.zeros((SIZE, SIZE))
    P[X, X], P[V, V] = p.noise[1] ** 2, p.noise[2] ** 2
    if not certain:
        P[E_K0:, E_K0:] = _belief(p)
    force, healthy = 0.0, np.ones(3)
    for k in range(begun):
        P = _seen(p, P, _shown(p, record.motion[k], force, healthy))
        P, force = _moved(p, record, k, force, healthy, P)
    return np.array([_after(p, record, left, new, begun, until, force, P.copy()) for new in news])


def _after(
    p: Estimator, record: Drive, left: Mapping[str, float], new: Sequence[str], begun: int,
    until: Sequence[int], force: float, P: Array,
) -> Array:  # fmt: skip
    """The bound (len(until), 3, 3) from the fault on, with the covariance P at its beginning."""
    factors, found = np.array([left.get(name, 1.0) for name in NAMES]), []
    for name in new:
        P[F1 + NAMES.index(name), F1 + NAMES.index(name)] = _ANY**2
    for k in range(begun, max(until)):
        P = _seen(p, P, _shown(p, record.motion[k], force, factors))
        if k + 1 in until:
            found.append(P[F1 : F3 + 1, F1 : F3 + 1])
        if k + 1 < len(record.samples):
            P, force = _moved(p, record, k, force, factors, P)
    return np.array(found)


def chance(deviation: float, limit: float) -> float:
    """Probability that an unbiased Gaussian estimate of this deviation is within the limit."""
    return math.erf(limit / (max(deviation, 1e-12) * math.sqrt(2.0)))


def told_apart(covariance: Array, left: Mapping[str, float]) -> float:
    r"""Probability that the best rule names the right fault, :math:`\Phi(d / 2)`.

    covariance (3, 3): where any factor may have changed; d: deviations between the true factors and the nearest ones
    of another single fault, of any size.
    """
    missing = np.array([1.0 - left.get(name, 1.0) for name in NAMES])
    nearest = math.inf
    for name in NAMES:
        if tuple(left) != (name,):
            rest = [i for i in range(3) if NAMES[i] != name]
            gap = missing[rest]
            square = gap @ np.linalg.solve(covariance[np.ix_(rest, rest)], gap)
            nearest = min(nearest, float(square))
    return 0.5 * (1.0 + math.erf(0.5 * math.sqrt(nearest) / math.sqrt(2.0)))


def _belief(p: Estimator) -> Array:
    """Covariance (N, N) of the model's errors before any sample."""
    information = np.zeros((N, N))
    information[np.tril_indices(N)] = p.prior[:TRIANGLE]
    return np.asarray(np.linalg.inv(information + np.tril(information, -1).T))


def _shown(p: Estimator, motion: Array, force: float, factors: Array) -> Array:
    """Derivative (SIZE,) of the body's acceleration by the state."""
    c, (x, v), (f1, f2, f3) = p.p, motion, factors
    stiff, viscous, field = c[K0] * x, c[C0] * v, force
    row = np.zeros(SIZE)
    row[X], row[V], row[F] = c[K_S] + f2 * c[K0], f2 * f3 * c[C0], f1 * f2 * f3
    row[F1], row[F2], row[F3] = (
        f2 * f3 * field, stiff + f3 * (viscous + f1 * field), f2 * (viscous + f1 * field),
    )  # fmt: skip
    row[E_K0], row[E_C0], row[E_SIGMA] = f2 * stiff, f2 * f3 * viscous, f1 * f2 * f3 * field
    row[E_KS], row[OFFSET] = c[K_S] * x, 1.0
    return np.asarray(-row / c[M_S])


def _seen(p: Estimator, P: Array, shown: Array) -> Array:
    """The covariance (SIZE, SIZE) after the sprung accelerometer and the deflection sensor."""
    H = np.zeros((3, SIZE))
    H[0], H[1, X], H[2, V] = shown, 1.0, 1.0
    M = H @ P @ H.T + np.diag(p.noise[:3] ** 2)
    P = P - P @ H.T @ np.linalg.solve(M, H @ P)
    return np.asarray(0.5 * (P + P.T))


def _moved(
    p: Estimator, record: Drive, k: int, force: float, factors: Array, P: Array
) -> tuple[Array, float]:
    """Covariance and yield force one sample later; the wheel's acceleration is known by its noisy sensor."""
    c, h, duty = p.p, DT / _PARTS, record.samples[k].duty
    height = c[SIGMA] * duty ** c[BETA] if duty > 0.0 else 0.0
    T = np.eye(SIZE)
    for j in range(_PARTS):
        share = (j + 0.5) / _PARTS
        motion = (1.0 - share) * record.motion[k] + share * record.motion[k + 1]
        x, v = motion
        gate = math.tanh(c[K1] * x + c[C1] * v)
        slope = height * (1.0 - gate * gate)
        A = np.zeros((SIZE, SIZE))
        A[X, V], A[V] = 1.0, _shown(p, motion, force, factors)
        rate = 1.0 / max(c[TAU], h)
        A[F, X], A[F, V], A[F, F] = slope * c[K1], slope * c[C1], -1.0
        A[F, E_K1], A[F, E_C1] = slope * c[K1] * x, slope * c[C1] * v
        A[F, E_TAU] = force - height * gate
        A[F] *= rate
        T = (np.eye(SIZE) + h * A + 0.5 * h * h * (A @ A)) @ T
        force += (1.0 - math.exp(-h * rate)) * (height * gate - force)
    P = T @ P @ T.T
    wheel = np.array([0.5 * DT**2, DT]) * p.noise[0]
    P[: V + 1, : V + 1] += np.outer(wheel, wheel)
    return P, force
