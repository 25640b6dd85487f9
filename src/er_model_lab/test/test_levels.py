"""Noise levels of the sensors: a search that pauses, and models of the motion that are given up early."""

from dataclasses import asdict, replace

import numpy as np
import pytest
from er_model_lab.motion import noise_levels
from er_model_lab.motion.fuse import channels_of, likelihood
from er_model_lab.motion.noise_levels import BEHIND, FIRST, count, estimate_noise

DT, N = 0.005, 1500
TRUE = {"x": 2e-5, "v": 1e-3, "a": 0.025}


def sines(rough, seed=4):
    """Channels of a motion of six sines, with steps of the acceleration that are `rough` times the noise in size."""
    rng, t = np.random.default_rng(seed), np.arange(N) * DT
    w = 2 * np.pi * np.array([0.7, 1.3, 2.1, 3.4, 5.2, 7.3])
    turns = np.exp(1j * (np.multiply.outer(t, w) + rng.uniform(0, 2 * np.pi, w.size)))
    x, v, a = ((turns * (0.09 / w / 2.5) * (1j * w) ** k).imag.sum(axis=1) for k in range(3))
    kinks = rough * TRUE["a"] * np.cumsum(rng.standard_normal(N))
    shown = (x + np.cumsum(np.cumsum(kinks)) * DT**2, v + np.cumsum(kinks) * DT, a + kinks)
    noise = (sd * rng.standard_normal(N) for sd in TRUE.values())
    return channels_of(DT, *(y + e for y, e in zip(shown, noise, strict=True)))


@pytest.mark.parametrize("rough", [0.0, 0.3, 10.0, 30.0, 100.0])
def test_what_was_given_up_early_would_not_have_won(rough, monkeypatch):
    ch = sines(rough)
    found = estimate_noise(ch)
    monkeypatch.setattr(noise_levels, "BEHIND", np.inf)
    whole = estimate_noise(ch)
    assert asdict(found) == asdict(whole)


def test_a_hopeless_model_of_the_motion_is_given_up(monkeypatch):
    asked = []

    def told(ch, noise):
        asked.append((noise.order, noise.local))
        return likelihood(ch, noise)

    monkeypatch.setattr(noise_levels, "likelihood", told)
    ch = sines(0.0)
    best = estimate_noise(ch)
    kinds = {kind: asked.count(kind) for kind in asked}
    assert len(kinds) == 4
    corners = 5
    assert min(kinds.values()) <= 2 * FIRST + corners < kinds[best.order, best.local]
    assert BEHIND > 0.0


def test_the_levels_are_those_of_the_sensors():
    found = estimate_noise(sines(0.0))
    for name, true in TRUE.items():
        assert getattr(found, name) == pytest.approx(true, rel=0.3), name


@pytest.mark.parametrize("free_lag", [False, True])
def test_a_search_that_pauses_ends_where_it_would_have_ended(free_lag):
    ch = sines(0.3)
    start = replace(noise_levels._start(ch, 4), lag=0.003)
    once, paused = (noise_levels._Search(ch, start, free_lag=free_lag) for _ in range(2))
    once.go_on()
    for _ in range(4):
        paused.go_on(7)
    paused.go_on()
    assert asdict(once.noise) == asdict(paused.noise)
    assert once.value == paused.value == -likelihood(ch, once.noise)


@pytest.mark.parametrize(("blur", "counts"), [(0.0, True), (1e-6, False)])
def test_an_encoder_at_a_halt_is_not_more_exact_than_its_counts(blur, counts):
    dt, step, rng = 0.002, 2e-5, np.random.default_rng(1)
    t = np.arange(2500) * dt
    x = 0.02 * np.sin(2.0 * np.pi * 0.7 * t)
    x = np.where((t % 2.0) < 0.8, x[100], x)
    read = np.round(x / step) * step + blur * rng.standard_normal(t.size)
    assert count(read) == pytest.approx(step if counts else 0.0)
    found = estimate_noise(channels_of(dt, read, None, None, np.zeros((t.size, 3), bool)))
    assert not counts or found.x >= step / np.sqrt(12.0) * (1.0 - 1e-9)


def test_counts_that_show_in_no_fast_motion_are_found_in_the_whole_record():
    """Where every sample moves by many counts they look like no noise at all."""
    step, t = 1.2e-6, np.arange(6000) * 5e-4
    x = 5e-3 * (1.0 - np.cos(12.0 * np.maximum(t - 2.0, 0.0)))
    whole = channels_of(5e-4, step * np.round(x / step), None, None)
    part = channels_of(5e-4, x[-1500:], None, None)
    assert estimate_noise(part).x < 0.01 * step
    assert estimate_noise(part, whole=whole).x == pytest.approx(step / np.sqrt(12.0))
