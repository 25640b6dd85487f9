"""Where a model fails, beyond what noise does there, and the noise from several sides."""

from types import SimpleNamespace

import numpy as np
import pytest
from er_model_lab.diagnosis.floor_estimates import floors
from er_model_lab.diagnosis.noise_floor import Floor, bounded
from er_model_lab.problem.prepare import prepare
from er_model_lab.residual.excess import noise_at, region_tables
from er_models.files import load_model
from er_models.prediction import motion, predict
from er_records.dataset import Dataset
from er_records.record import Record
from lab_help import DT, FORCE_NOISE, GUO, imposed, problem_of


@pytest.fixture(scope="module")
def problem():
    return problem_of("coulomb_friction", {"F_c": 1.0, "v_0": 0.003}, seconds=40.0)[1]


def regions(problem, residual, noise=None, seed=0):
    return {t.quantity: t.regions for t in region_tables(problem, residual, seed, noise)}


def test_excess_is_what_was_put_in_and_only_there(problem):
    rng = np.random.default_rng(1)
    slow = np.abs(problem.motion.v) < 0.01
    residual = 0.2 * rng.standard_normal(slow.size) + np.where(slow, 0.5, 0.0)
    found = regions(problem, residual, np.full(slow.size, 0.04))
    for r in found["velocity"]:
        inside = slow[
            problem.used & (problem.motion.v >= r.edges[0]) & (problem.motion.v < r.edges[1])
        ]
        expected = 0.5 * np.sqrt(inside.mean())
        low, high = r.excess_band
        assert 0.8 * low - 0.03 <= expected <= 1.2 * high + 0.03, r
        assert r.excess == pytest.approx(np.sqrt(max(r.rms**2 - r.floor**2, 0.0)))
    assert [r.floor for r in found["duty"]] == pytest.approx([0.2] * len(found["duty"]))


def test_bands_cover_the_truth_as_often_as_they_say(problem):
    rng = np.random.default_rng(2)
    hits, total = 0, 0
    for seed in range(40):
        residual = 0.3 * rng.standard_normal(problem.force.size)
        for group in regions(problem, residual, seed=seed).values():
            if group[0].quantity in ("velocity", "deflection", "duty"):
                hits += sum(r.band[0] <= 0.3 <= r.band[1] for r in group)
                total += len(group)
    assert 0.80 < hits / total < 0.95


def test_a_bin_that_is_only_noisier_shows_no_excess(problem):
    rng = np.random.default_rng(3)
    gate = np.where(np.abs(problem.motion.v) < 0.005, 0.25, 0.01)
    residual = np.sqrt(gate + 0.01) * rng.standard_normal(gate.size)
    floor = float(np.sqrt(np.mean((gate + 0.01)[problem.train])))
    noise = noise_at(problem, floor, gate)
    assert np.mean(noise[problem.train]) == pytest.approx(floor**2)
    blind = regions(problem, residual, np.full(gate.size, floor**2))["velocity"]
    aware = regions(problem, residual, noise)["velocity"]
    assert max(r.excess for r in blind) > 0.2
    assert max(r.excess for r in aware) < 0.1


def test_frequency_bands_share_the_power_and_name_the_tone(problem):
    t = np.arange(problem.force.size) * DT
    residual = 0.4 * np.sin(2 * np.pi * 30.0 * t) + 0.05 * np.random.default_rng(
        4
    ).standard_normal(t.size)
    found = regions(problem, residual, np.full(t.size, 0.0025))["frequency"]
    assert sum(r.share for r in found) == pytest.approx(1.0, abs=1e-6)
    loud = max(found, key=lambda r: r.share)
    assert loud.edges == (20.0, 40.0)
    assert loud.excess == pytest.approx(0.4 / np.sqrt(2.0), rel=0.03)
    assert loud.share > 5.0 * loud.of_samples
    assert loud.band[0] < loud.rms < loud.band[1]


def test_the_same_seed_gives_the_same_bands(problem):
    residual = np.random.default_rng(5).standard_normal(problem.force.size)
    one, two, other = (regions(problem, residual, seed=s)["velocity"] for s in (1, 1, 2))
    assert one == two
    assert one != other


def made(x, u, seed=0):
    """A problem on a given deflection with friction that the model does not know, and what the model leaves."""
    rng, n = np.random.default_rng(seed), x.size
    v = np.gradient(x, DT)
    a = np.gradient(v, DT)
    model = load_model(GUO)
    truth = model.with_effect("coulomb_friction", {"F_c": 1.0, "v_0": 0.003})
    channels = {
        "deflection": x + 2e-5 * rng.standard_normal(n),
        "deflection_velocity": v + 1e-3 * rng.standard_normal(n),
        "duty": u,
        "damper_force": predict(truth, motion(DT, x, v, u, a))
        + FORCE_NOISE * rng.standard_normal(n),
        "sprung_acceleration": a + 0.025 * rng.standard_normal(n),
        "unsprung_acceleration": 0.025 * rng.standard_normal(n),
    }
    problem = prepare(Dataset.of([Record("made", np.arange(n) * DT, channels)]))
    return problem, problem.force - problem.predict(model)


def sides(problem, residual):
    return floors(problem, residual, Floor(0.2, 0.2, 0.15, 0.1, 0.0, {}, (0.0, 0.0, 0.0)))


def test_no_noise_of_held_out_data_is_louder_than_what_a_model_that_was_tried_leaves_there(
    problem,
):
    floor = Floor(0.2, 0.5, 0.15, 0.1, 0.0, {}, (0.0, 0.0, 0.0))

    def tried(left):
        residual = np.where(problem.held_out, left, 0.01)
        return SimpleNamespace(fit=SimpleNamespace(residual=residual))

    assert bounded(floor, [tried(0.6), tried(0.3)], problem).held_out == pytest.approx(0.3)
    assert bounded(floor, [tried(0.6)], problem) == floor
    assert bounded(floor, [], problem) == floor


def test_repeated_motion_gives_the_noise_though_the_model_is_wrong():
    t = np.arange(5000) * DT
    problem, left = made(6e-3 * np.sin(2 * np.pi * 2.0 * t), np.where(t % 4.0 < 2.0, 0.1, 0.3))
    assert np.sqrt(np.mean(left**2)) > 3.0 * FORCE_NOISE
    found = sides(problem, left)["repeats"]
    assert found.value == pytest.approx(FORCE_NOISE, rel=0.06)
    assert 0.0 < found.sd < 0.01
    assert sides(problem, left)["standstill"].value is None


def test_rest_gives_the_noise_of_the_force_and_a_slow_motion_is_none():
    x = imposed(np.random.default_rng(0), 5000)[0]
    t = np.arange(5000) * DT
    ramp = np.clip(np.abs(t - 12.0) - 2.0, 0.0, 1.0)
    u = np.full(5000, 0.1)
    problem, left = made(x * ramp**3 * (10 - 15 * ramp + 6 * ramp**2), u)
    found = sides(problem, left)
    assert found["standstill"].value == pytest.approx(
        FORCE_NOISE, abs=4.0 * found["standstill"].sd
    )
    both = found["standstill_and_motion_sensors"].value
    assert both == pytest.approx(np.hypot(found["standstill"].value, 0.1))
    slow, left = made(5e-3 * np.sin(2 * np.pi * 0.02 * t), u)
    assert sides(slow, left)["standstill"].value is None


def test_random_motion_has_no_repeats():
    rng = np.random.default_rng(7)
    n = 4000
    f = np.fft.rfftfreq(n, DT)
    x = np.fft.irfft(
        np.where((f > 0.3) & (f < 8.0), 1.0, 0.0) * np.exp(2j * np.pi * rng.uniform(size=f.size)),
        n,
    )
    problem, left = made(5e-3 * x / np.std(x), np.zeros(n))
    found = sides(problem, left)["repeats"]
    assert found.value is None
    assert "no motion is repeated" in found.says
