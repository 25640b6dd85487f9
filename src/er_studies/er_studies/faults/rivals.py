"""Other ways to the factors, for comparison: they see the same motion and rows, and say factors only.

`forgetting`: recursive least squares of the three shares and an offset, old rows fading within a second, with rows that
are made for what it has found so far. `adaptive`: the same shares moved against the normalised gradient of the error.
`horizon`: the estimator itself, which learns nothing of the healthy damper beforehand (a moving horizon with arrival
cost, but no belief of its own). `descriptor`: the lost force by the H-infinity observer of (2.19), with a motion of its
own, and its shares as `forgetting`'s.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from er_models.constants import SAMPLE_TIME as DT
from er_models.model import Array
from er_observers.faults import estimator as ours
from er_observers.faults import tick
from er_observers.faults.regression import BETA, C0, C1, K0, K1, K_S, M_S, SIGMA, TAU
from er_observers.faults.rules import Estimator
from er_observers.faults.sample import Sample
from er_observers.faults.sums import ROWS, SIZE, TRIANGLE, N, add
from er_observers.observers.gate import mean_gate
from scipy.linalg import expm

FADING, GAIN = 1.0, 0.01
"""Memory of the forgetting one [s]; step of the adaptive one [1]."""
_SHARES = [0, 1, 2, 4]


def factors(p: Estimator, samples: Sequence[Sample], name: str, K: Array) -> Array:
    """Factors f1, f2, f3 after each sample, (n, 3); K (3, 2): gain of the descriptor observer."""
    if name in ("ours", "horizon"):
        setup = p.setup.copy()
        if name == "horizon":
            setup[tick.KEPT], setup[tick.CALM] = 0.0, float(tick.BLOCKS)
        return _ours(replace(p, setup=setup), samples)
    if name == "descriptor":
        shares, found = _Forgetting(), []
        for row in _observed(p, samples, K):
            found.append(_factors(shares.after(row)))
        return np.array(found)
    if name in ("forgetting", "adaptive"):
        return _recursive(p, samples, _Forgetting() if name == "forgetting" else _Adaptive())
    raise ValueError(name)


def _ours(p: Estimator, samples: Sequence[Sample]) -> Array:
    state = ours.start(p, samples[0])
    found = [state.estimate.factors]
    for sample in samples[1:]:
        state, estimate = ours.step(p, state, sample)
        found.append(estimate.factors)
    return np.array(found)


def _recursive(p: Estimator, samples: Sequence[Sample], rule: _Forgetting | _Adaptive) -> Array:
    """Factors of a rule that gets the sum (SIZE,) of each sample's rows, made for the shares it said before."""
    memory, before = ours.start(p, samples[0]).memory.copy(), samples[0].t
    known, found = p.first[:N].copy(), [np.ones(3)]
    for s in samples[1:]:
        memory[tick.BLOCK], memory[tick.COUNTED][tick.FILLED] = 0.0, 0.0
        a = (s.sprung_acceleration, s.unsprung_acceleration)
        seen = (s.deflection, s.deflection_velocity)
        tick.run(p.p, p.noise, p.setup, a, seen, s.duty, s.force, s.t - before, memory)
        before = s.t
        known[_SHARES] = rule.after(memory[tick.BLOCK])
        known[:3] = np.clip(known[:3], 0.05, 1.2)
        tick.expect(memory, known)
        found.append(np.array(_factors(known)))
    return np.array(found)


def _observed(p: Estimator, samples: Sequence[Sample], K: Array) -> list[Array]:
    """Sums (SIZE,) of one row each: the force less the lost one, by the observer, against the healthy terms."""
    c, A = p.p, np.array([[0.0, 1.0], [0.0, 0.0]]) - K[:2]
    block = expm(DT * np.block([[A, np.array([[0.0], [1.0]]), K[:2]], [np.zeros((3, 5))]]))
    q, force, found, before = np.zeros(2), 0.0, [np.zeros(SIZE)], samples[0]
    kept = math.exp(-DT / c[TAU]) if c[TAU] > 0.0 else 0.0
    for s in samples[1:]:
        relative = s.sprung_acceleration - s.unsprung_acceleration
        rates = before.sprung_acceleration - before.unsprung_acceleration, relative
        height = c[SIGMA] * before.duty ** c[BETA] if before.duty > 0.0 else 0.0
        seen = 0.5 * (np.array(before[3:5]) + np.array(s[3:5]))
        new = block[:2, :2] @ q + block[:2, 2:] @ [0.5 * sum(rates), *seen]
        gate = mean_gate(c[K1] * q[0] + c[C1] * q[1], c[K1] * new[0] + c[C1] * new[1])[0]
        force = kept * force + (1.0 - kept) * height * gate
        force += DT * float(K[2] @ (seen - 0.5 * (q + new)))
        q = new
        left = -c[M_S] * s.sprung_acceleration - c[K_S] * q[0]
        row, phi = np.zeros(SIZE), np.zeros(N)
        phi[:3], phi[4] = (c[K0] * q[0], c[C0] * q[1], force), 1.0
        add(row, phi, left, 1.0 / (c[M_S] * p.noise[0]) ** 2)
        found.append(row)
        before = s
    return found


class _Forgetting:
    """Shares and offset by recursive least squares; the belief is what a healthy damper of 5 % tolerance has."""

    def __init__(self) -> None:
        self.total = np.zeros(SIZE)

    def after(self, row: Array) -> Array:
        """Shares and offset (4,) after a sum of rows."""
        if row[ROWS] > 0.0:
            self.total = math.exp(-DT / FADING) * self.total + row
        A = _matrix(self.total)[np.ix_(_SHARES, _SHARES)] + np.diag([4.0, 4.0, 4.0, 1e-3])
        m = self.total[TRIANGLE : TRIANGLE + N][_SHARES] + np.array([4.0, 4.0, 4.0, 0.0])
        return np.asarray(np.linalg.solve(A, m))


class _Adaptive:
    """Shares and offset by the normalised gradient."""

    def __init__(self) -> None:
        self.shares = np.array([1.0, 1.0, 1.0, 0.0])

    def after(self, row: Array) -> Array:
        """Shares and offset (4,) after a sum of rows."""
        if row[ROWS] > 0.0:
            A = _matrix(row)[np.ix_(_SHARES, _SHARES)]
            error = row[TRIANGLE : TRIANGLE + N][_SHARES] - A @ self.shares
            self.shares = self.shares + GAIN * error / (GAIN + np.trace(A)) * 4.0
        return self.shares


def _matrix(total: Array) -> Array:
    A = np.zeros((N, N))
    A[np.tril_indices(N)] = total[:TRIANGLE]
    return np.asarray(A + np.tril(A, -1).T)


def _factors(shares: Array) -> tuple[float, float, float]:
    """Factors from shares, within 0 to 1."""
    k, c, y = np.maximum(shares[:3], 0.05)
    return tuple(float(np.clip(f, 0.0, 1.0)) for f in (y / c, k, c / k))  # type: ignore[return-value]
