"""Other ways to the factors, for comparison: they see the same rows, and say factors only.

`forgetting`: recursive least squares of the three shares and an offset, old rows fading within a second. `adaptive`:
the same shares moved against the normalised gradient of the error. `horizon`: the estimator itself, which learns
nothing of the healthy damper beforehand (a moving horizon with arrival cost, but no belief of its own). `descriptor`:
the lost force by the H-infinity observer of (2.19), with a motion of its own, and its shares as `forgetting`'s.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from er_models.model import Array
from scipy.linalg import expm

from er_observers.faults import estimator as ours
from er_observers.faults import tick
from er_observers.faults.regression import C0, DOUBT, F_ER, K0, K_S, M_S, advance
from er_observers.faults.rules import Estimator
from er_observers.faults.sample import Sample
from er_observers.faults.sums import ROWS, SIZE, TRIANGLE, N, add
from er_observers.scenarios.drive import DT

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
        return _forgetting(_observed(p, samples, K))
    rows = _rows(p, samples)
    if name == "forgetting":
        return _forgetting(rows)
    if name == "adaptive":
        return _adaptive(rows)
    raise ValueError(name)


def _ours(p: Estimator, samples: Sequence[Sample]) -> Array:
    state = ours.start(p, samples[0])
    found = [state.estimate.factors]
    for sample in samples[1:]:
        state, estimate = ours.step(p, state, sample)
        found.append(estimate.factors)
    return np.array(found)


def _rows(p: Estimator, samples: Sequence[Sample]) -> list[Array]:
    """Sums (SIZE,) of one row each, zeros where the estimator takes none."""
    state = ours.start(p, samples[0])
    memory, found, before = state.memory.copy(), [np.zeros(SIZE)], samples[0].t
    for s in samples[1:]:
        memory[tick.BLOCK], memory[tick.FILLED] = 0.0, 0.0
        a = (s.sprung_acceleration, s.unsprung_acceleration)
        seen = (s.deflection, s.deflection_velocity)
        tick.run(p.p, p.noise, p.setup, a, seen, s.duty, s.force, s.t - before, p.room, memory)
        before = s.t
        found.append(memory[tick.BLOCK].copy())
    return found


def _observed(p: Estimator, samples: Sequence[Sample], K: Array) -> list[Array]:
    """Sums (SIZE,) of one row each: the force less the lost one, by the observer, against the healthy terms."""
    c, A = p.p, np.array([[0.0, 1.0], [0.0, 0.0]]) - K[:2]
    block = expm(DT * np.block([[A, np.array([[0.0], [1.0]]), K[:2]], [np.zeros((3, 5))]]))
    q, fluid, found, before = np.zeros(2), np.zeros(DOUBT + 1), [np.zeros(SIZE)], samples[0]
    for s in samples[1:]:
        relative = s.sprung_acceleration - s.unsprung_acceleration
        rates = before.sprung_acceleration - before.unsprung_acceleration, relative
        seen = 0.5 * (np.array(before[3:5]) + np.array(s[3:5]))
        new = block[:2, :2] @ q + block[:2, 2:] @ [0.5 * sum(rates), *seen]
        advance(c, fluid, (q[0], new[0]), (q[1], new[1]), rates, 0.0, before.duty, DT)
        fluid[F_ER] += DT * (K[2] @ (seen - 0.5 * (q + new)))
        q = new
        kept = -c[M_S] * s.sprung_acceleration - c[K_S] * q[0]
        row, phi = np.zeros(SIZE), np.zeros(N)
        phi[:3], phi[4] = (c[K0] * q[0], c[C0] * q[1], fluid[F_ER]), 1.0
        add(row, phi, kept, 1.0 / (c[M_S] * p.noise[0]) ** 2)
        found.append(row)
        before = s
    return found


def _forgetting(rows: list[Array]) -> Array:
    """Shares by recursive least squares; the belief is what a healthy damper of 5 % tolerance has."""
    kept = np.exp(-0.005 / FADING)
    total, found = np.zeros(SIZE), []
    for row in rows:
        total = kept * total + row if row[ROWS] > 0.0 else total
        A = _matrix(total)[np.ix_(_SHARES, _SHARES)] + np.diag([4.0, 4.0, 4.0, 1e-3])
        m = total[TRIANGLE : TRIANGLE + N][_SHARES] + np.array([4.0, 4.0, 4.0, 0.0])
        found.append(_factors(np.linalg.solve(A, m)))
    return np.array(found)


def _adaptive(rows: list[Array]) -> Array:
    """Shares by the normalised gradient."""
    shares, found = np.array([1.0, 1.0, 1.0, 0.0]), []
    for row in rows:
        if row[ROWS] > 0.0:
            A = _matrix(row)[np.ix_(_SHARES, _SHARES)]
            error = row[TRIANGLE : TRIANGLE + N][_SHARES] - A @ shares
            shares = shares + GAIN * error / (GAIN + np.trace(A)) * 4.0
        found.append(_factors(shares))
    return np.array(found)


def _matrix(total: Array) -> Array:
    A = np.zeros((N, N))
    A[np.tril_indices(N)] = total[:TRIANGLE]
    return np.asarray(A + np.tril(A, -1).T)


def _factors(shares: Array) -> tuple[float, float, float]:
    """Factors from shares, within 0 to 1."""
    k, c, y = np.maximum(shares[:3], 0.05)
    return tuple(float(np.clip(f, 0.0, 1.0)) for f in (y / c, k, c / k))  # type: ignore[return-value]
