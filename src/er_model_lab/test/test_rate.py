"""Records that are sampled faster than their content needs."""

import numpy as np
import pytest
from er_model_lab.preflight.rate import MOST, SHARP, at_needed_rate
from er_records.record import Record

RATE = 1000.0


def record(rate=RATE, force=None, noise=0.1, duty=None):
    """A slow motion that begins and ends in the middle of it, with an encoder's steps, and a smooth force."""
    n = round(8.0 * rate)
    t, rng = np.arange(n) / rate, np.random.default_rng(2)
    x = 0.01 * np.sin(2 * np.pi * 3.0 * t + 0.7)
    y = 40.0 * np.cos(2 * np.pi * 3.0 * t + 0.7) if force is None else force
    channels = {
        "deflection": np.round(x / 5e-6) * 5e-6,
        "duty": (t % 0.8 < 0.402) * 0.3 if duty is None else duty,
        "damper_force": y + noise * rng.standard_normal(n),
    }
    return Record("run", t, channels), x, y


@pytest.mark.parametrize("rate", [RATE, 10_000.0])
def test_a_slow_motion_is_brought_to_200_hz_and_no_end_is_bent(rate):
    given, x, force = record(rate)
    found = at_needed_rate(given)
    every = round(found.dt / given.dt)
    assert 200.0 <= 1.0 / found.dt <= MOST
    assert "Hz are filtered to" in found.notes[-1]
    assert np.abs(found.channels["deflection"] - x[::every]).max() < 5e-6
    wrong = found.channels["damper_force"] - force[::every]
    assert np.abs(wrong).max() < 0.4
    assert (
        np.std(wrong) < 0.09 * np.sqrt(5.0 / every) + 0.03
    )  # noise between the samples is filtered in, not lost


def test_a_duty_that_jumps_between_two_samples_is_its_mean_there():
    given, _, _ = record()
    found = at_needed_rate(given)
    every = round(found.dt / given.dt)
    duty = found.channels["duty"]
    assert np.sum(duty) * every == pytest.approx(np.sum(given.channels["duty"]), rel=1e-3)
    assert np.any((duty > 0.0) & (duty < 0.3))


@pytest.mark.parametrize(("noise", "kept"), [(4.0, MOST), (0.1, SHARP)])
def test_a_force_that_jumps_keeps_a_rate_that_shows_it(noise, kept):
    """Of jumps of 80 N a filter to 500 Hz loses 2 N: less than the one noise, far more than the other."""
    t = np.arange(40_000) / 5000.0
    jumps = 40.0 * np.sign(np.sin(2 * np.pi * 1.7 * t))
    given, _, _ = record(5000.0, force=jumps, noise=np.sqrt(10.0) * noise, duty=0.0 * t)
    assert 1.0 / at_needed_rate(given).dt == pytest.approx(kept)


@pytest.mark.parametrize(("at", "rate", "kept"), [
    (2003, 5000.0, SHARP), (2010, 5000.0, MOST), (2003, 1000.0, MOST)
])  # fmt: skip
def test_a_duty_that_jumps_between_samples_of_a_fast_force_keeps_more_of_its_time(at, rate, kept):
    """Its mean over 2 ms acts later than the jump did; at 1 kHz nothing is left to be gained."""
    n = round(8.0 * rate)
    jumps = 4.0 * np.sign(np.sin(2 * np.pi * 1.7 * np.arange(n) / rate))
    given, _, _ = record(rate, force=jumps, noise=1.2, duty=0.3 * (np.arange(n) >= at))
    assert 1.0 / at_needed_rate(given).dt == pytest.approx(kept)


def test_content_above_the_noise_is_kept_however_small():
    """A ripple of 0.1 N at 60 Hz on 40 N is a millionth of the variance: an effect, where the noise is less."""
    t = np.arange(8000) / RATE
    force = 40.0 * np.sin(2 * np.pi * 3.0 * t) + 0.1 * np.sin(2 * np.pi * 60.0 * t)
    rates = [1.0 / at_needed_rate(record(force=force, noise=noise)[0]).dt for noise in (0.01, 1.0)]
    assert rates == pytest.approx([333.3, 200.0], rel=1e-3)


def test_a_wild_sample_marks_what_it_was_filtered_into():
    given, _, _ = record()
    mask = np.zeros(8000, bool)
    mask[4003] = True
    given = Record("run", given.t, given.channels, wild={"damper_force": mask})
    found = at_needed_rate(given)
    every = round(found.dt / given.dt)
    assert set(np.flatnonzero(found.wild["damper_force"])) >= {4003 // every, 4003 // every + 1}
    assert found.wild["damper_force"].sum() <= 3


@pytest.mark.parametrize("rate", [100.0, 200.0, 333.0])
def test_a_rate_that_is_needed_stays(rate):
    given, _, _ = record(rate)
    assert at_needed_rate(given) is given
