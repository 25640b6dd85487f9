"""Checks and repairs every format shares: gaps, holes, dead channels, jitter, velocity."""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from er_models.errors import InputError
from er_records.clean import clean
from er_records.record import Array, Record

N, DT = 2000, 0.005


def record(n: int = N, **channels: Array) -> Record:
    """A 200 Hz record with a sine deflection, force and stepped duty; channels can be replaced."""
    t = DT * np.arange(n)
    x = 5e-3 * np.sin(2 * np.pi * 2.0 * t)
    own: Mapping[str, Array] = {
        "deflection": x,
        "damper_force": 1e3 * x,
        "duty": np.where(np.arange(n) % 400 < 200, 0.0, 0.3),
    }
    return Record("run", t, {**own, **channels}, source="run.csv")


def holed(samples: Array, *runs: tuple[int, int]) -> Array:
    """Samples with NaN in the runs [i, j)."""
    samples = samples.copy()
    for i, j in runs:
        samples[i:j] = np.nan
    return samples


def test_gaps_of_five_samples_are_bridged_and_of_six_split() -> None:
    raw = record()
    force = raw.channels["damper_force"]
    (bridged,) = clean(record(damper_force=holed(force, (100, 105), (300, 301))))
    assert bridged.complete
    assert "damper_force: 6 missing samples bridged in 2 gaps" in bridged.notes
    np.testing.assert_allclose(bridged.channels["damper_force"], force, atol=0.02)
    straight = np.interp(np.arange(99, 106), [99, 105], force[[99, 105]])
    np.testing.assert_allclose(bridged.channels["damper_force"][99:106], straight, rtol=1e-12)
    pieces = clean(record(damper_force=holed(force, (1000, 1006))))
    assert [p.name for p in pieces] == ["run#1", "run#2"]
    assert [len(p) for p in pieces] == [1000, N - 1006]
    assert not any(p.complete for p in pieces)
    assert pieces[1].t[0] == raw.t[1006]
    assert any("6 rows cut where damper_force" in note for note in pieces[0].notes)


def test_a_bridged_duty_holds_its_last_value() -> None:
    duty = record().channels["duty"]
    (bridged,) = clean(record(duty=holed(duty, (198, 203))))
    np.testing.assert_array_equal(bridged.channels["duty"][198:203], np.zeros(5))
    np.testing.assert_array_equal(bridged.channels["duty"][203:], duty[203:])


def test_start_up_may_be_missing_but_not_more() -> None:
    force = record().channels["damper_force"]
    (short,) = clean(record(damper_force=holed(force, (0, 80))))
    assert short.complete
    assert len(short) == N - 80
    (long,) = clean(record(damper_force=holed(force, (0, 500))))
    assert not long.complete
    assert long.name == "run"
    assert long.t[0] == record().t[500]


def test_dead_and_nearly_dead_channels_are_dropped_with_a_note() -> None:
    dead = np.full(N, np.nan)
    (one,) = clean(record(road=dead))
    assert one.complete
    assert "road has no valid sample and was dropped" in one.notes
    mostly = holed(np.zeros(N), (100, 1500))
    (two,) = clean(record(sprung_acceleration=mostly))
    assert not two.complete
    assert not two.has("sprung_acceleration")
    assert len(two) == N
    with pytest.raises(InputError, match="only missing samples"):
        clean(Record("run", DT * np.arange(N), {"deflection": dead}))


def test_a_slow_temperature_is_interpolated_and_does_not_cut_the_rest() -> None:
    warm = np.full(N, np.nan)
    warm[::200] = np.linspace(0.0, 9.0, N // 200)
    (one,) = clean(record(temperature=warm))
    assert one.complete
    assert len(one) == N
    assert one.channels["temperature"][100] == pytest.approx(0.5)


def test_estimates_keep_their_invalid_samples() -> None:
    estimate = holed(np.ones(N), (0, 700))
    (one,) = clean(record(force_unified=estimate))
    assert len(one) == N
    np.testing.assert_array_equal(one.channels["force_unified"], estimate)


def test_repeated_rows_are_dropped() -> None:
    raw = record()
    rows = np.sort(np.concatenate((np.arange(N), [50, 50, 900])))
    held = {name: samples[rows] for name, samples in raw.channels.items()}
    (one,) = clean(replace(raw, t=raw.t[rows], channels=held))
    assert "3 repeated rows (same time, same samples) dropped" in one.notes
    np.testing.assert_array_equal(one.t, raw.t)


def test_a_hole_in_time_splits_and_a_lost_tick_is_resampled() -> None:
    raw = record()
    keep = np.ones(N, dtype=bool)
    keep[700] = False
    (one,) = clean(_rows(raw, keep))
    assert len(one) == N
    assert any("jitter 100 %" in note for note in one.notes)
    np.testing.assert_allclose(one.channels["deflection"], raw.channels["deflection"], atol=5e-6)
    keep[1000:1006] = False
    pieces = clean(_rows(raw, keep))
    assert [p.name for p in pieces] == ["run#1", "run#2"]
    assert not pieces[0].complete
    assert any("hole of 0.035 s" in note for note in pieces[0].notes)
    keep[:] = True
    keep[1000:1005] = False
    assert len(clean(_rows(raw, keep))) == 1


def test_nothing_is_bridged_across_a_hole_in_time() -> None:
    raw = record()
    keep = np.ones(N, dtype=bool)
    keep[1000:1300] = False
    force = holed(raw.channels["damper_force"], (998, 1000))
    pieces = clean(_rows(record(damper_force=force), keep))
    assert [len(p) for p in pieces] == [998, 700]
    for piece in pieces:
        rows = np.round(piece.t / DT).astype(int)
        true = raw.channels["damper_force"][rows]
        np.testing.assert_array_equal(piece.channels["damper_force"], true)


def test_small_jitter_is_left_and_large_jitter_resampled() -> None:
    raw = record()
    random = np.random.default_rng(3)
    shaken = np.sort(raw.t + random.uniform(-0.04, 0.04, N) * DT)
    (kept,) = clean(replace(raw, t=shaken))
    np.testing.assert_array_equal(kept.t, shaken)
    # steps of 1.06 and 0.94 of the nominal one, the median being the longer
    slightly_more = raw.t + np.where(np.arange(N) % 2, 0.06, 0.0) * DT
    (even,) = clean(replace(raw, t=slightly_more))
    assert any("jitter 11 %" in note for note in even.notes)
    shaken = raw.t + random.uniform(-0.3, 0.3, N) * DT
    true = {"deflection": 5e-3 * np.sin(2 * np.pi * 2.0 * shaken)}
    (even,) = clean(Record("run", shaken, true))
    assert float(np.ptp(np.diff(even.t))) < 1e-9
    ideal = 5e-3 * np.sin(2 * np.pi * 2.0 * even.t)
    # a straight line across 1.6 steps misses a sine of this curvature by 6.3 um at most
    np.testing.assert_allclose(even.channels["deflection"], ideal, atol=6.4e-6)
    assert any("uneven" in note for note in even.notes)


def test_steps_of_the_duty_come_in_time_where_stamps_are_off() -> None:
    """Rows taken evenly, stamped up to 1.5 ms early or late: the steps are neither early nor late on average."""
    random = np.random.default_rng(4)
    duty = np.repeat(np.arange(N // 10), 10) / N
    shaken = DT * np.arange(N) + random.uniform(-0.3, 0.3, N) * DT
    (even,) = clean(Record("run", shaken, {**record().channels, "duty": duty}))
    assert any("uneven" in note for note in even.notes)
    seen = even.t[np.flatnonzero(np.diff(even.channels["duty"])) + 1]
    late = seen - DT * np.arange(10, N, 10)[: seen.size]
    assert abs(np.mean(late)) < 0.05 * DT
    assert np.max(np.abs(late)) < DT


def test_short_pieces_are_dropped_and_named() -> None:
    force = record().channels["damper_force"]
    pieces = clean(record(damper_force=holed(force, (150, 160))))
    assert [p.name for p in pieces] == ["run#2"]
    assert "run#1 (150 samples) is too short and was dropped" in pieces[0].notes
    every = holed(force, *((k, k + 10) for k in range(100, N, 200)))
    with pytest.raises(InputError, match="longest piece without gaps has"):
        clean(record(damper_force=every))


def test_the_derived_velocity_is_right_where_a_central_difference_is_not() -> None:
    t = DT * np.arange(N)
    w = 2 * np.pi * 15.0
    x = 1e-3 * np.sin(w * t)
    (one,) = clean(Record("run", t, {"deflection": x}))
    true = 1e-3 * w * np.cos(w * t)
    inner = slice(5, -5)
    error = np.max(np.abs(one.channels["deflection_velocity"] - true)[inner]) / (1e-3 * w)
    central = np.max(np.abs(np.gradient(x, DT) - true)[inner]) / (1e-3 * w)
    assert error < 0.01
    assert central > 0.035
    assert one.derived == ("deflection_velocity",)
    noise = 2e-5 * np.random.default_rng(1).standard_normal(N)
    (noisy,) = clean(Record("run", t, {"deflection": noise}))
    spread = noisy.channels["deflection_velocity"][inner].std()
    assert spread == pytest.approx(0.72 * np.gradient(noise, DT)[inner].std(), rel=0.05)


def test_a_measured_velocity_is_kept() -> None:
    v = np.zeros(N)
    (one,) = clean(record(deflection_velocity=v))
    assert one.derived == ()
    np.testing.assert_array_equal(one.channels["deflection_velocity"], v)


def test_a_clean_record_passes_unchanged_and_twice_is_once() -> None:
    (once,) = clean(record())
    (twice,) = clean(once)
    assert twice.notes == once.notes
    for name in once.channels:
        np.testing.assert_array_equal(twice.channels[name], once.channels[name])


def test_records_are_read_only_and_survive_pickling() -> None:
    one = record()
    with pytest.raises(ValueError, match="read-only"):
        one.channels["duty"][0] = 1.0
    back = pickle.loads(pickle.dumps(one))
    assert back.name == one.name
    np.testing.assert_array_equal(back.channels["duty"], one.channels["duty"])
    part = one.slice(10, 20)
    assert len(part) == 10
    assert part.t[0] == one.t[10]
    assert one.dt == pytest.approx(DT)
    with pytest.raises(InputError, match=r"deflection.*2000 samples"):
        Record("run", one.t, {"deflection": one.t[:5]})


def _rows(raw: Record, keep: Array) -> Record:
    """The rows to keep."""
    channels = {name: samples[keep] for name, samples in raw.channels.items()}
    return replace(raw, t=raw.t[keep], channels=channels)


def test_heights_of_body_and_wheel_give_the_deflection_that_was_not_measured() -> None:
    whole = record()
    x = whole.channels["deflection"]
    heights = {"sprung_displacement": 3.0 * x, "unsprung_displacement": 2.0 * x}
    bare = {k: y for k, y in whole.channels.items() if k != "deflection"}
    (made,) = clean(replace(whole, channels=bare | heights))
    np.testing.assert_allclose(made.channels["deflection"], x, atol=1e-15)
    assert {"deflection", "deflection_velocity"} == {*made.derived}
    (kept,) = clean(replace(whole, channels=whole.channels | heights))
    assert "deflection" not in kept.derived
