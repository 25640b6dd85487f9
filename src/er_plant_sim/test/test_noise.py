"""Sensor errors: as stated, reproducible, and independent of how they are asked for."""

import numpy as np
from er_plant_sim.noise import BLOCK, PERFECT, Errors, Noise, errors

STATED = Errors(0.025, 0.03, 2e-5, 1e-3, 0.15)


def test_deviation_and_bias_are_as_stated() -> None:
    noise = Noise(STATED, Errors(0.5, 0.0, 1e-3, 0.0, -2.0), seed=3)
    drawn = np.array([errors(noise, k) for k in range(20_000)])
    assert np.allclose(drawn.std(axis=0), STATED, rtol=0.02)
    assert np.allclose(drawn.mean(axis=0), noise.bias, atol=4 * np.array(STATED) / np.sqrt(20_000))


def test_white_and_uncorrelated() -> None:
    drawn = np.array([errors(Noise(STATED, seed=3), k) for k in range(20_000)]) / np.array(STATED)
    assert np.all(np.abs(np.corrcoef(drawn.T) - np.eye(5)) < 0.04)
    assert np.all(np.abs(np.mean(drawn[1:] * drawn[:-1], axis=0)) < 0.04)


def test_the_error_at_a_tick_does_not_depend_on_what_was_asked_before() -> None:
    noise = Noise(STATED, seed=5)
    ticks = [3 * BLOCK + 2, 0, BLOCK - 1, BLOCK, 7]
    first = [errors(noise, k) for k in ticks]
    assert [errors(noise, k) for k in reversed(ticks)] == first[::-1]
    assert len(set(first)) == len(ticks)


def test_seeds_differ_and_no_noise_is_nothing() -> None:
    assert errors(Noise(STATED, seed=1), 4) != errors(Noise(STATED, seed=2), 4)
    assert errors(Noise(seed=1), 4) == PERFECT
