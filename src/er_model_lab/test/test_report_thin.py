"""Thinning that keeps peaks, packing that keeps samples, and the stretch that is shown first."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from er_model_lab.output.report.live_marks import packed
from er_model_lab.output.report.thin import (
    MOST_POINTS,
    end_to_end,
    every,
    min_max,
    stretches,
    timeline,
    worst_stretch,
)
from er_model_lab.view import Array
from hypothesis import given, settings
from hypothesis import strategies as st
from report_views import record, rms


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 30_000), st.integers(0, 2**32 - 1), st.integers(10, 5000))
def test_thinning_keeps_the_extremes_the_ends_and_the_limit(n: int, seed: int, most: int) -> None:
    y = np.random.default_rng(seed).standard_normal(n)
    rows = min_max(y, most)
    assert rows.size <= max(most, 4)
    assert np.all(np.diff(rows) > 0)
    assert {0, n - 1, int(np.argmax(y)), int(np.argmin(y))} <= set(rows.tolist())


def test_a_spike_of_one_sample_survives() -> None:
    y = np.zeros(720_000)
    y[123_456] = 5.0
    rows = min_max(y)
    assert 123_456 in rows
    assert rows.size <= MOST_POINTS


def test_short_series_and_gaps_are_kept() -> None:
    assert min_max(np.arange(50.0), 50).size == 50
    y = np.ones(10_000)
    y[4003] = np.nan
    assert 4003 in min_max(y), "a gap must still break the curve, however short"


def unpacked(p: dict) -> Array:
    """What the page does: sums of the differences, in steps above the lowest value."""
    rises = np.array([np.nan if r is None else r for r in p["rises"]])
    out = np.full(rises.size, np.nan)
    good = np.isfinite(rises)
    out[good] = p["low"] + p["step"] * np.cumsum(rises[good])
    return out


@pytest.mark.parametrize("grain", [0.0, 0.01])
def test_packed_curves_come_back_within_half_a_step(grain: float) -> None:
    y = 20.0 * np.random.default_rng(3).standard_normal(5000)
    y[100:110] = np.nan
    p = packed(y, grain)
    np.testing.assert_allclose(unpacked(p), y, atol=0.51 * p["step"])
    assert p["step"] >= grain


def test_a_time_axis_is_packed_as_equal_steps() -> None:
    t = np.concatenate([np.arange(4000) / 200.0, [np.nan], 30.0 + np.arange(4000) / 200.0])
    p = packed(t)
    np.testing.assert_allclose(unpacked(p), t, atol=1e-3)
    assert p["rises"][1:4000] == [4] * 3999


def test_nothing_finite_can_be_packed() -> None:
    assert packed(np.full(3, np.nan))["rises"] == [None] * 3


def test_stretches_of_a_mask() -> None:
    t = np.arange(6.0)
    assert stretches(t, np.array([1, 1, 0, 0, 1, 0], bool)) == ((0.0, 1.0), (4.0, 4.0))
    assert stretches(t, np.zeros(6, bool)) == ()


def test_records_are_laid_end_to_end_with_a_gap_no_curve_crosses() -> None:
    parts = [record("a", 3.0, 1), record("b", 2.0, 2)]
    first, second = timeline(parts)
    assert second[0] > first[-1]
    joined = end_to_end([p.measured for p in parts])
    assert np.isnan(joined[first.size])
    assert joined.size == first.size + second.size + 1
    alone = replace(parts[0], t=parts[0].t + 40.0)
    np.testing.assert_array_equal(timeline([alone])[0], alone.t)


def test_the_worst_stretch_is_where_the_error_is() -> None:
    r = record("a", 20.0, 1)
    bad = (r.t > 11.0) & (r.t < 14.0)
    r = replace(r, before=r.measured + np.where(bad, 3.0, 0.1))
    low, high, size = worst_stretch(r, 5.0)
    assert low <= 11.0
    assert high >= 14.0
    inside = (r.t >= low) & (r.t <= high)
    assert size == pytest.approx(rms((r.measured - r.before)[inside]), rel=1e-9)
    blind = replace(r, scored=~bad)
    assert worst_stretch(blind, 5.0)[2] < 0.2, "what is not scored must not decide"


def test_every_spreads_evenly_and_never_repeats() -> None:
    assert every(10, 100).tolist() == list(range(10))
    rows = every(10_007, 500)
    assert rows.size == 500
    assert rows[-1] == 10_006
