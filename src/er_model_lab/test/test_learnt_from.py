"""What only scores decides nothing: noise levels, lag, and whether a motion repeats itself are read off the rest."""

import numpy as np
import pytest
from er_model_lab.diagnosis.coverage import _different, coverage
from er_model_lab.problem.prepare import prepare
from er_records.dataset import Dataset
from er_records.record import Record
from lab_help import DT, imposed


def record(name, seconds=12.0, noise=1.0, lag=0.0, seed=1, sine=0.0):
    """A motion of six sines, or of one [Hz], with its channels."""
    rng, n = np.random.default_rng(seed), round(seconds / DT)
    x, v, a, u = imposed(rng, n)
    if sine:
        w = 2 * np.pi * sine
        t = np.arange(n) * DT
        x, v, a = 0.01 * np.sin(w * t), 0.01 * w * np.cos(w * t), -0.01 * w**2 * np.sin(w * t)
    channels = {
        "deflection": x + noise * 2e-5 * rng.standard_normal(n), "duty": u, "damper_force": 60.0 * v,
        "deflection_velocity": v - lag * a + noise * 1e-3 * rng.standard_normal(n),
    }  # fmt: skip
    return Record(name, np.arange(n) * DT, channels)


def test_noise_and_lag_are_those_of_the_data_learnt_from():
    learnt = record("learnt")
    sealed = record("sealed", 16.0, noise=4.0, lag=0.006, seed=2)
    alone, beside = prepare(Dataset.of([learnt])), prepare(Dataset.of([learnt], [sealed]))
    assert beside.noise.v == pytest.approx(alone.noise.v, rel=1e-9)
    assert beside.velocity_lag[0] == pytest.approx(alone.velocity_lag[0], abs=1e-9)
    assert prepare(Dataset.of([learnt, sealed])).velocity_lag[0] == pytest.approx(0.006, rel=0.1)


def test_of_records_that_are_spared_whole_no_noise_is_read_off():
    records = [record(str(k), noise=1.0 + k, seed=k) for k in range(4)]
    problem = prepare(Dataset.of(records))
    spared = {k for k, i in enumerate(problem.motion.starts[:-1]) if problem.held_out[i + 500]}
    first = min(set(range(4)) - spared)
    assert problem.noise.v == pytest.approx((1.0 + first) * 1e-3, rel=0.2)


def test_a_rich_record_that_only_scores_makes_no_sine_rich():
    one, rich = record("sine", sine=2.0), record("rich", seed=2)
    found = coverage(prepare(Dataset.of([one], [rich])))
    assert "repeats one closed curve" in found.blocking[0]
    assert found.seconds == pytest.approx(coverage(prepare(Dataset.of([one]))).seconds, abs=4.0)
    assert found.seconds < 13.0
    assert coverage(prepare(Dataset.of([one, rich]))).blocking == ()


@pytest.mark.parametrize("lengths", [(10.0, 16.0, 25.0), (10.0, 10.0, 10.0)])
def test_one_frequency_is_one_in_records_of_whatever_length(lengths):
    records = [record(f"{s:g}", s, sine=2.0, seed=k) for k, s in enumerate(lengths)]
    assert coverage(prepare(Dataset.of(records))).tones == 1


def test_lines_of_one_record_are_never_joined():
    assert _different([[(1.0, 0.4), (1.3, 0.4)], [(1.1, 0.1), (2.0, 0.1)]]) == 3
