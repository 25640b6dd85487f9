"""Motion that is known from a velocity alone: its drift is taken out, of long records as of short ones."""

import numpy as np
import pytest
from er_model_lab.motion.drift import drift
from er_model_lab.problem import stretches
from er_model_lab.problem.prepare import prepare
from er_model_lab.span.whole_record import on_whole
from er_records.dataset import Dataset
from er_records.record import Record
from lab_help import DT, imposed


def test_up_to_a_minute_and_a_half_the_drift_is_a_straight_line():
    t = np.arange(round(70.0 / DT)) * DT
    x = 0.003 + 5e-4 * t + 0.01 * np.sin(9.0 * t)
    line, slope = drift(x, DT)
    assert line == pytest.approx(np.polyval(np.polyfit(t, x, 1), t), abs=1e-9)
    assert slope == pytest.approx(np.polyfit(t, x, 1)[0], abs=1e-9)


def test_of_longer_records_it_bends_once_a_minute_and_its_slope_is_that_of_the_line():
    t = np.arange(round(300.0 / DT)) * DT
    line, slope = drift(1e-6 * t**2, DT)
    assert np.max(np.abs(line - 1e-6 * t**2)) < 1e-3
    assert np.unique(np.round(slope, 12)).size == 5
    inner = slope[2:] == slope[:-2]
    assert np.diff(line)[1:][inner] == pytest.approx(DT * slope[1:-1][inner], abs=1e-9)


@pytest.mark.parametrize("offset", [0.0, 5e-4])
def test_an_offset_of_the_velocity_carries_no_long_record_away(offset, monkeypatch):
    monkeypatch.setattr(stretches, "LONG", 8000)
    monkeypatch.setattr(stretches, "USED", 6000)
    rng, n = np.random.default_rng(3), round(200.0 / DT)
    x, v, _, u = imposed(rng, n)
    channels = {
        "deflection_velocity": v + offset + 1e-3 * rng.standard_normal(n), "duty": u, "damper_force": 60.0 * v
    }  # fmt: skip
    data = stretches.shortened(Dataset.of([Record("run", np.arange(n) * DT, channels)]))
    _, found = on_whole(prepare(data), data)
    whole = found.motion
    missed = whole.x - x
    assert np.std(missed) < 0.2 * np.std(x)
    assert np.max(np.abs(np.diff(missed))) < 2e-5  # no jump where two pieces meet
    assert np.std(whole.v - v) < 1e-3


def test_each_long_record_keeps_its_own_channels(monkeypatch):
    monkeypatch.setattr(stretches, "LONG", 3000)
    monkeypatch.setattr(stretches, "USED", 2900)
    rng, n = np.random.default_rng(4), round(12.0 / DT)
    x, v, _, u = imposed(rng, n)
    force = {"duty": u, "damper_force": 60.0 * v}
    records = [
        Record("x", np.arange(n) * DT, {"deflection": x + 2e-5 * rng.standard_normal(n), **force}),
        Record("v", np.arange(n) * DT, {"deflection_velocity": v + 1e-3 * rng.standard_normal(n), **force}),
    ]  # fmt: skip
    data = stretches.shortened(Dataset.of(records))
    _, whole = on_whole(prepare(data), data)
    moved = whole.motion
    for i, j in ((0, n), (n, 2 * n)):
        assert np.std(moved.v[i:j] - v) < 0.1 * np.std(v)
