"""Motion from any subset of the channels: what is lost is said, and each accelerometer's bias is found."""

from dataclasses import replace

import numpy as np
import pytest
from er_model_lab.motion.white_noise import white_noise
from er_model_lab.preflight.check import preflight
from er_model_lab.preflight.usable_channels import use_findings
from er_model_lab.problem.fusion_facts import biases, fusion_json
from er_model_lab.problem.prepare import prepare, resampled
from er_model_lab.residual.excess import quantities
from er_models.errors import MissingChannel
from er_models.files import load_model
from er_models.prediction import motion, predict
from er_records.dataset import Dataset, Place
from er_records.missing_channels import losses
from er_records.record import Record
from er_records.sampling import with_velocity
from lab_help import DT, FORCE_NOISE, GUO, imposed

ACCELERATIONS = ("sprung_acceleration", "unsprung_acceleration")
BIAS = (0.05, -0.03)


def ride(seed, n=4000, offset=0.0):
    """A record on a wheel that shakes, with biased accelerometers and a velocity channel off by `offset`."""
    rng = np.random.default_rng(seed)
    x, v, a, u = imposed(rng, n)
    w = 2 * np.pi * 1.9
    wheel = 0.8 * np.sin(w * np.arange(n) * DT + seed)
    noise = 0.025 * rng.standard_normal((2, n))
    channels = {
        "deflection": x + 2e-5 * rng.standard_normal(n),
        "deflection_velocity": v + offset + 1e-3 * rng.standard_normal(n),
        "duty": u,
        "damper_force": predict(load_model(GUO), motion(DT, x, v, u, a))
        + FORCE_NOISE * rng.standard_normal(n),
        "sprung_acceleration": a + wheel + BIAS[0] + noise[0],
        "unsprung_acceleration": wheel + BIAS[1] + noise[1],
    }
    return Record(f"r{seed}", np.arange(n) * DT, channels)


@pytest.fixture(scope="module")
def rides():
    return [ride(1), ride(2)]


def without(record, *names):
    return with_velocity(
        replace(record, channels={k: y for k, y in record.channels.items() if k not in names})
    )


def error(problem):
    """Rms error of the true model along the fused motion, over the noise of the force."""
    left = (problem.force - problem.predict(load_model(GUO)))[problem.used]
    return float(np.sqrt(np.mean(left**2))) / FORCE_NOISE


def test_white_noise_is_that_beside_a_smooth_signal_and_knows_of_lost_samples():
    rng, n = np.random.default_rng(4), 20_000
    noisy = 5.0 * np.sin(2.0 * np.pi * 1.5 * np.arange(n) * DT) + 0.02 * rng.standard_normal(n)
    assert white_noise([noisy]) == pytest.approx(0.02, rel=0.05)
    assert white_noise([noisy[:9000], noisy[9000:]]) == pytest.approx(0.02, rel=0.05)
    noisy[::100] = np.nan
    assert white_noise([noisy]) == pytest.approx(0.02, rel=0.05)
    assert white_noise([noisy[:3]]) == white_noise([np.full(9, np.nan)]) == 0.0


def test_each_bias_is_found_within_its_deviation_and_the_difference_far_better(rides):
    found = biases(rides, prepare(Dataset.of(rides)).fused)
    for name, truth in zip(ACCELERATIONS, BIAS, strict=True):
        value, sd = found[name]
        assert abs(value - truth) < 4.0 * sd
        assert sd < 0.02
    value, sd = found["relative"]
    assert value == pytest.approx(BIAS[0] - BIAS[1], abs=4.0 * sd)
    assert sd < 0.3 * found["sprung_acceleration"][1]
    assert value == pytest.approx(
        found["sprung_acceleration"][0] - found["unsprung_acceleration"][0], abs=2.0 * sd
    )


def test_what_cannot_be_known_is_said(rides):
    records = [without(r, ACCELERATIONS[1]) for r in rides]
    said = fusion_json(records, prepare(Dataset.of(records)))
    assert said["bias"]["relative"]["value"] is None
    assert said["bias"]["unsprung_acceleration"]["says"] == "channel absent"
    assert said["bias"]["sprung_acceleration"]["value"] == pytest.approx(BIAS[0], abs=0.03)
    assert said["noise"]["acceleration"] is None
    assert any("one acceleration alone" in s for s in said["lost"])


@pytest.mark.parametrize(
    ("gone", "most"),
    [
        ((), 1.15), (("deflection_velocity",), 1.2), (ACCELERATIONS, 1.7), (("deflection",), 2.2),
        ((*ACCELERATIONS, "deflection_velocity"), 3.5), ((*ACCELERATIONS, "deflection"), 2.6),
    ],
)  # fmt: skip
def test_any_subset_gives_a_usable_motion(rides, gone, most):
    records = [without(r, *gone) for r in rides]
    assert 0.9 < error(prepare(Dataset.of(records))) < most
    assert bool(losses(records)) is bool(gone)


def test_noise_of_a_high_rate_at_rest_is_no_motion():
    """Positioning after 2 s of rest, at 2 kHz: from sample to sample an encoder's noise moves as much as the damper.

    The intensity of the motion was read off the rest, and what moved afterwards was smoothed away.
    """
    dt, noise = 5e-4, 7e-7
    t = np.arange(16000) * dt
    x = 5e-4 * (1.0 - np.cos(2.0 * np.pi * 0.7 * np.maximum(t - 2.0, 0.0)))
    measured = x + noise * np.random.default_rng(1).standard_normal(t.size)
    record = Record("moves", t, {"deflection": measured, "damper_force": 1e3 * x})
    found = prepare(Dataset.of([with_velocity(record)])).motion
    inner = slice(100, -100)
    assert np.std((found.x - x)[inner]) < noise
    assert np.std((found.v - np.gradient(x, dt))[inner]) < 0.02 * np.std(np.gradient(x, dt))


def test_a_slow_record_beside_fast_ones_is_said_to_slow_them(rides):
    slow = Record("slow", rides[0].t[::2], {n: y[::2] for n, y in rides[0].channels.items()})
    (said,) = losses([*rides, slow])
    assert said.startswith("rates from 100 to 200 Hz")
    assert prepare(Dataset.of([*rides, slow])).motion.dt == pytest.approx(0.01)


@pytest.mark.parametrize("ratio", [2, 3, 4, 5])
def test_averaging_to_a_slower_rate_shifts_neither_a_rest_nor_a_ramp(ratio):
    t = np.arange(600 * ratio) * DT / ratio
    duty = np.repeat(np.arange(600) % 2, ratio)
    noisy = 2e-5 * np.random.default_rng(0).standard_normal(t.size)
    channels = {
        "deflection": 0.02 + 0.0 * t,
        "road": 0.02 - 0.3 * t,
        "duty": duty,
        "damper_force": noisy,
    }
    fast = Record("fast", t, channels)
    rest, ramp, held, averaged = (resampled(fast, name, DT) for name in channels)
    grid = np.arange(rest.size) * DT
    assert rest.size in (599, 600)
    np.testing.assert_allclose(rest, 0.02, rtol=1e-12)
    np.testing.assert_allclose(ramp, 0.02 - 0.3 * grid, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(held, np.arange(rest.size) % 2, atol=1e-6)
    assert averaged.std() == pytest.approx(2e-5 / np.sqrt(ratio), rel=0.2)


def test_the_temperature_of_all_records_counts_from_one_reference(rides):
    n = len(rides[0])
    warm, hot = (
        replace(r, channels={**r.channels, "temperature": start + np.linspace(0.0, 1.0, n)})
        for r, start in zip(rides, (20.0, 60.0), strict=False)
    )
    problem = prepare(Dataset.of([rides[1], warm, hot]))
    assert [problem.motion.theta[k * n] for k in range(3)] == [0.0, 0.0, 40.0]
    np.testing.assert_array_equal(
        prepare(Dataset.of([hot])).motion.theta, hot.channels["temperature"] - 60.0
    )
    assert ("temperature", "K") in [
        (name, unit) for name, unit, _ in quantities(problem, problem.force)
    ]
    assert preflight([warm, hot]).have["warming"] == pytest.approx(41.0)
    late = Dataset((hot.slice(1000, n),), (), Dataset.of([warm, hot]), (Place(1, 1000, n),))
    assert prepare(late).motion.theta[0] == pytest.approx(40.25, abs=1e-3)


def test_an_offset_of_the_velocity_does_not_carry_the_deflection_away():
    problem = prepare(Dataset.of([without(ride(3, offset=1e-3), "deflection")]))
    assert error(problem) < 2.2
    assert np.ptp(problem.motion.x) < 0.04


def test_records_may_have_different_channels(rides):
    whole = prepare(Dataset.of(rides))
    poorer = without(ride(4, n=6000), *ACCELERATIONS)
    mixed = prepare(Dataset.of([*rides, poorer]))
    for own, other in zip(whole.fused, mixed.fused, strict=False):
        assert other.sd_v == pytest.approx(own.sd_v, rel=0.1)
        assert other.bias == pytest.approx(own.bias, abs=3e-3)
    assert mixed.noise.a == pytest.approx(whole.noise.a, rel=0.1)
    assert any("(1 of 3 records)" in n for n in mixed.notes)
    assert error(mixed) < 1.5


def test_accelerations_alone_are_not_enough_and_by_how_much(rides):
    alone = [without(r, "deflection", "deflection_velocity") for r in rides]
    with pytest.raises(
        MissingChannel, match=r"or deflection_velocity.* may drift by 1[0-9] mm/s in 20 s"
    ):
        prepare(Dataset.of(alone))
    found = preflight(alone, levels=True)
    assert (found.verdict, found.failures[0].check) == ("not_usable", "channels")
    u = alone[0].channels["duty"]
    whole = [replace(r, channels={**r.channels, "road": 0.0 * u}) for r in alone]
    assert preflight(whole, levels=True).passed
    assert [f.remedy for f in use_findings(whole[0])] == ["use level='vehicle'"]
    assert not list(use_findings(rides[0]))


def test_records_that_each_lack_another_channel_know_the_noise_of_both(rides):
    slow = without(rides[0], "deflection_velocity")
    blind = without(rides[1], *ACCELERATIONS).slice(0, 3000)
    mixed = prepare(Dataset.of([slow, blind]))
    assert mixed.noise.v == pytest.approx(1e-3, rel=0.15)
    alone = prepare(Dataset.of([blind]))
    assert mixed.fused[1].sd_v == pytest.approx(alone.fused[0].sd_v, rel=0.15)
