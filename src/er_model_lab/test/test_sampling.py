"""Times that are rounded, rates that change, and records of several rates."""

from dataclasses import replace

import numpy as np
import pytest
from er_model_lab.preflight.samples import time_findings
from er_model_lab.problem.prepare import resampled
from er_records.record import Record
from er_records.sampling import even, with_velocity
from er_records.timing import timing_of
from scipy.signal import savgol_filter


def sine(t, f=1.3):
    """A record of one sine and its derivative."""
    w = 2 * np.pi * f
    return Record(
        "run", t, {"deflection": np.sin(w * t), "deflection_velocity": w * np.cos(w * t)}
    )


@pytest.mark.parametrize(
    ("rate", "digits"), [(512.0, 4), (512.0, 3), (300.0, 4), (1024.0, 5), (333.0, 4)]
)
def test_rounded_times_are_taken_for_equal_steps(rate, digits):
    t = np.arange(round(20.0 * rate)) / rate
    given = replace(sine(t), t=np.round(t, digits))
    found = even(given)
    assert all(np.array_equal(found.channels[c], y) for c, y in given.channels.items())
    assert found.dt == pytest.approx(1.0 / rate, rel=1e-4)
    assert found.t == pytest.approx(t, abs=1.1 * 10.0**-digits)
    slope = np.gradient(found.channels["deflection"], found.dt)
    ratio = slope @ found.channels["deflection_velocity"] / np.sum(slope**2)
    assert ratio == pytest.approx(1.0, abs=2e-3)
    if abs(np.median(np.diff(np.round(t, digits))) * rate - 1.0) > 1e-3:
        assert "times are rounded" in found.notes[-1]


def test_of_times_since_1970_too():
    t = 1_700_000_000.0 + np.arange(6000) / 512.0
    found = even(replace(sine(t), t=np.round(t, 3)))
    assert found.dt == pytest.approx(1.0 / 512.0, rel=1e-4)
    assert "times are rounded" in found.notes[-1]


def test_times_rounded_by_a_logger_are_no_jitter():
    """A logger at 300 Hz that writes milliseconds steps by 3, 3 and 4 ms."""
    stored = timing_of(np.round(1e3 * np.arange(3000) / 300.0) / 1e3)
    assert (1.0 / stored.dt, stored.jitter) == (pytest.approx(300.0, rel=1e-6), 0.0)
    finding = next(time_findings(replace(sine(np.arange(9.0)), timing=stored)))
    assert (finding.level, finding.found) == ("ok", "300 Hz, times rounded to 1 ms")
    t = np.arange(3000) / 300.0 + np.random.default_rng(1).uniform(-1e-3, 1e-3, 3000)
    assert timing_of(np.round(t, 3)).jitter > 5e-4


def test_jitter_in_rounded_times_is_jitter():
    t = np.arange(6000) * 0.005 + np.random.default_rng(1).uniform(-0.002, 0.002, 6000)
    assert "sampling is uneven" in even(sine(np.round(t, 4))).notes[-1]


def test_times_that_are_even_stay_as_they_are():
    rng = np.random.default_rng(0)
    t = np.arange(4000) * 0.005
    for kept in (t, t + 1e-4 * rng.uniform(-1, 1, t.size)):
        record = sine(kept)
        assert even(record) is record


def test_a_rate_that_changes_is_resampled():
    t = np.cumsum(np.concatenate([np.full(6000, 0.0050), np.full(4000, 0.0053)]))
    found = even(sine(t))
    assert "the sample time changes" in found.notes[-1]
    assert np.ptp(np.diff(found.t)) < 1e-9
    assert found.channels["deflection"] == pytest.approx(
        np.sin(2 * np.pi * 1.3 * found.t), abs=1e-3
    )


def test_on_a_coarser_grid_the_duty_is_the_one_in_force():
    t = np.arange(1000) * 0.004
    duty = np.where(np.floor(t / 0.3) % 2 == 0, 0.0, 0.3)
    record = Record("run", t, {"duty": duty, "damper_force": t})
    coarse = resampled(record, "duty", 0.005)
    assert set(np.unique(coarse)) == {0.0, 0.3}
    grid = np.arange(t[0], t[-1], 0.005)
    assert coarse == pytest.approx(
        np.where(np.floor((grid + 1e-9) / 0.3) % 2 == 0, 0.0, 0.3), abs=0.31
    )
    late = np.mean(coarse != np.where(np.floor((grid + 1e-9) / 0.3) % 2 == 0, 0.0, 0.3))
    assert late < 0.02


def test_rates_that_differ_by_half_a_percent_are_two_rates():
    t = np.arange(4000) * 0.005 / 1.005
    record = Record("run", t, {"deflection": t})
    found = resampled(record, "deflection", 0.005)
    assert np.diff(found) == pytest.approx(0.005, abs=1e-9)


@pytest.mark.parametrize("n", [7, 8, 300])
def test_a_derived_velocity_is_the_slope_of_a_cubic_through_seven_samples(n):
    x = np.random.default_rng(n).standard_normal(n).cumsum()
    found = with_velocity(Record("run", np.arange(n) / 200.0, {"deflection": x}))
    wanted = savgol_filter(x, 7, 3, deriv=1, delta=found.dt)
    assert np.allclose(found.channels["deflection_velocity"], wanted, rtol=1e-9, atol=1e-9)
