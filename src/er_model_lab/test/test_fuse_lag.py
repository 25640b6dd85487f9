"""A velocity channel with a lag of its own: how long, and the motion behind it."""

import numpy as np
import pytest
from er_model_lab.motion.fuse import as_measured
from er_model_lab.problem.prepare import prepare
from er_records.dataset import Dataset
from er_records.record import Record

DT, N = 0.005, 3000
W = 2 * np.pi * np.array([0.7, 1.3, 2.1, 3.4, 5.2, 7.3])


def lagging(lag, seed, noise=1.0):
    """A record of six sines whose velocity channel lags, its true velocity, and what that channel shows."""
    rng, t = np.random.default_rng(seed), np.arange(N) * DT
    size, phase = 0.09 / W / 2.5, rng.uniform(0, 2 * np.pi, W.size)
    turns = np.exp(1j * (np.multiply.outer(t, W) + phase))
    x, v, a = ((turns * size * (1j * W) ** k).imag.sum(axis=1) for k in range(3))
    behind = (turns * size * 1j * W / (1.0 + 1j * W * lag)).imag.sum(axis=1)
    channels = {
        "deflection": x + noise * 2e-5 * rng.standard_normal(N),
        "deflection_velocity": behind + noise * 1e-3 * rng.standard_normal(N),
        "sprung_acceleration": a + noise * 0.025 * rng.standard_normal(N),
        "unsprung_acceleration": noise * 0.025 * rng.standard_normal(N),
        "damper_force": 60.0 * v,
        "duty": np.zeros(N),
    }
    return Record("lagging", t, channels), v, behind


@pytest.mark.parametrize("lag", [0.0, 0.006, 0.02])
def test_the_lag_and_the_motion_behind_it_are_found(lag):
    record, v, behind = lagging(lag, 3)
    found, sd = prepare(Dataset.of([record])).velocity_lag
    assert abs(found - lag) < 4.0 * sd
    assert sd < max(0.01 * lag, 5e-5)
    problem = prepare(Dataset.of([record]), velocity_lag=lag)
    inner = slice(60, -60)
    assert np.std((problem.motion.v - v)[inner]) < 2.5e-4
    shown = as_measured(problem.fused[0], DT)[:, 1]
    assert np.std((shown - behind)[inner]) < 2.5e-4
