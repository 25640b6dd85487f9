"""Wild samples are found, told, and change neither a verdict nor a value; what is sharp but real is left alone."""

from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from er_model_lab.diagnosis.noise_floor import spectral_line
from er_model_lab.level.damper import opened
from er_model_lab.preflight.bent_ends import bent_ends
from er_model_lab.preflight.check import findings
from er_model_lab.preflight.finding import MOST, spans_of
from er_model_lab.preflight.samples import clipped as clipped_runs
from er_model_lab.preflight.samples import time_findings
from er_model_lab.preflight.spikes import spikes
from er_model_lab.preflight.wild import marked, places
from er_model_lab.problem.prepare import prepare
from er_model_lab.problem.problem import Problem
from er_model_lab.verbs.check import check
from er_model_lab.verbs.compare import compare
from er_model_lab.verbs.diagnose import diagnose
from er_models.files import load_model
from er_models.prediction import motion, predict
from er_records.dataset import Dataset
from er_records.record import Record
from er_records.timing import timing_of
from lab_help import DT, FORCE_NOISE, GUO, imposed

HIDDEN = ("coulomb_friction", {"F_c": 1.0, "v_0": 0.003})


def record(effect=None, seconds=16.0, seed=3):
    """A record of the Guo damper, with a hidden effect or complete."""
    model, rng, n = load_model(GUO), np.random.default_rng(seed), round(seconds / DT)
    x, v, a, u = imposed(rng, n)
    truth = model.with_effect(*effect) if effect else model
    channels = {
        "deflection": x + 2e-5 * rng.standard_normal(n),
        "deflection_velocity": v + 1e-3 * rng.standard_normal(n),
        "duty": u,
        "damper_force": predict(truth, motion(DT, x, v, u, a)) + FORCE_NOISE * rng.standard_normal(n),
        "sprung_acceleration": a + 0.025 * rng.standard_normal(n),
        "unsprung_acceleration": 0.025 * rng.standard_normal(n),
    }  # fmt: skip
    return Record("made", np.arange(n) * DT, channels)


def changed(given, name, y):
    return Record(given.name, given.t, {**given.channels, name: y})


def scattered(given):
    """0.5 % of the forces are anything within three times their range."""
    y, rng = given.channels["damper_force"].copy(), np.random.default_rng(8)
    rows = rng.choice(y.size, round(0.005 * y.size), replace=False)
    y[rows] = 3.0 * np.abs(y).max() * rng.uniform(-1.0, 1.0, rows.size)
    return changed(given, "damper_force", y)


def bent(given):
    """Three samples at either end as a filter that decimates leaves them."""
    y = given.channels["sprung_acceleration"].copy()
    y[:3], y[-3:] = (44.0, 25.0, 9.0), (-9.0, -25.0, -44.0)
    return changed(given, "sprung_acceleration", y)


def struck(given):
    y = given.channels["sprung_acceleration"].copy()
    y[1234] += 60.0
    return changed(given, "sprung_acceleration", y)


def clipped(given):
    """A load cell at the end of its range for 0.4 s."""
    y = given.channels["damper_force"].copy()
    top = np.abs(y).max() * 1.05
    k = int(np.argmax(np.abs(y[400:-400]))) + 400
    y[k - 40 : k + 40] = top
    return changed(given, "damper_force", y)


def cut_below(given):
    """A load cell whose amplifier ends at two thirds of what other samples reach, for 0.4 s."""
    y = given.channels["damper_force"].copy()
    y[1000:1080] = 0.66 * y.max()
    return changed(given, "damper_force", y)


def hangs(given):
    """A velocity channel that stands still for 0.3 s."""
    y = given.channels["deflection_velocity"].copy()
    y[1500:1560] = 1.01 * y[1499]
    return changed(given, "deflection_velocity", y)


KINDS = {
    "scattered": scattered, "bent": bent, "struck": struck, "clipped": clipped, "cut_below": cut_below, "hangs": hangs,
}  # fmt: skip


@pytest.fixture(scope="module")
def clean():
    return {None: record(), HIDDEN[0]: record(HIDDEN)}


@pytest.mark.parametrize("seed", range(6))
def test_nothing_is_wild_in_sound_data(seed):
    for effect in (None, HIDDEN):
        assert marked(record(effect, seed=seed)).wild == {}


@pytest.mark.parametrize("kind", KINDS)
def test_wild_samples_are_found_and_told(clean, kind):
    given = clean[HIDDEN[0]]
    spoilt = KINDS[kind](given)
    truly = {c: spoilt.channels[c] != given.channels[c] for c in given.channels}
    found = marked(spoilt)
    for name, mask in found.wild.items():
        assert np.mean(truly[name][mask]) > (0.5 if kind == "bent" else 0.99)
        assert mask.sum() >= 0.85 * truly[name].sum()
    said = check(Dataset.of([spoilt])).to_dict()
    assert said["outliers"]["count"] == sum(p["samples"] for p in places(found)) > 0
    assert any("wild" in note for note in said["notes"])
    worst = {
        "scattered": "spikes", "struck": "spikes", "bent": "ends", "clipped": "clipping", "cut_below": "held",
        "hangs": "held",
    }  # fmt: skip
    assert worst[kind] in {f["check"] for f in said["preflight"]["findings"] if f["level"] != "ok"}


@pytest.mark.parametrize("kind", KINDS)
def test_a_comparison_is_as_without_them(clean, kind):
    model = load_model(GUO)
    for given in clean.values():
        before, after = (compare(Dataset.of([r]), model) for r in (given, KINDS[kind](given)))
        assert after.rmse == pytest.approx(before.rmse, rel=0.05)
        assert after.to_dict()["outliers"]["count"] > 0


def same(before, after):
    """Verdict and names are the same, every value within two deviations."""
    assert (after.verdict, after.effects) == (before.verdict, before.effects)
    for effect, values in before.model.effects.items():
        for name, value in values.items():
            sd = before.model.deviations.get(effect, {}).get(name, 0.0)
            if np.isfinite(sd) and sd > 0.0:
                assert abs(after.model.value(effect, name) - value) < 2.0 * sd, (effect, name)


@pytest.mark.slow
@pytest.mark.parametrize("effect", [None, HIDDEN[0]])
def test_no_verdict_and_no_value_changes(clean, effect):
    """Four kinds in one record."""
    spoilt = clean[effect]
    for kind in ("scattered", "bent", "struck", "clipped"):
        spoilt = KINDS[kind](spoilt)
    before, after = (diagnose(Dataset.of([r]), load_model(GUO)) for r in (clean[effect], spoilt))
    same(before, after)
    assert after.effects == ((effect,) if effect else ())


def test_a_corner_of_the_road_strikes_the_wheel_for_one_sample(clean):
    y = clean[None].channels["sprung_acceleration"].copy()
    y[1234] += 0.2 * np.ptp(y)
    assert marked(changed(clean[None], "sprung_acceleration", y)).wild == {}


PULSES = {
    "step": [0.0, 0.0, 1.0, 1.0, 1.0], "corner": [0.0, 0.0, 0.0, 1.0, 2.0], "stop": [0.0, 0.3, 1.0, 0.3, 0.0],
    "two": [0.0, 1.0, 1.0, 0.0, 0.0], "edge": [0.0, 0.0, 0.5, 1.0, 1.0],
}  # fmt: skip


@pytest.mark.parametrize("size", [5.0, 20.0, 50.0, 1000.0])
@pytest.mark.parametrize("shape", PULSES)
def test_what_lasts_several_samples_is_not_wild(shape, size):
    rng = np.random.default_rng(1)
    y = rng.standard_normal(3000)
    for k in range(50, 2900, 60):
        y[k : k + 5] += size * np.array(PULSES[shape])
        if shape in ("step", "edge", "corner"):
            y[k + 5 : k + 60] += size * PULSES[shape][-1]
    assert not spikes(y).any()


def test_an_end_is_bent_where_it_parts_from_another_channel_after_a_harsh_motion():
    """The third difference of a jerk inside is larger than that of the bent end; the velocity tells them apart."""
    t, rng = np.arange(2000) * 0.005, np.random.default_rng(4)
    x = 3e-3 * np.where(t < 8.0, np.abs(np.sin(7.0 * t)), 1.0)
    apart = 5e-6 * rng.standard_normal(t.size - 1)
    x += 2e-6 * rng.standard_normal(t.size)
    assert not bent_ends(x, apart).any()
    moved = np.concatenate([x[:-3], x[-3:] - (10e-6, 40e-6, 250e-6)])
    assert not bent_ends(moved).any()
    parted = apart + np.diff(moved - x)
    assert np.flatnonzero(bent_ends(moved, parted)).tolist() == [1997, 1998, 1999]
    assert np.flatnonzero(bent_ends(moved[::-1], parted[::-1])).tolist() == [0, 1, 2]
    assert not bent_ends(moved, apart).any()


def test_two_spikes_that_chance_puts_together_are_both_found():
    y = np.random.default_rng(2).standard_normal(3000)
    rows = [100, 400, 700, 1000, 1500, 1501, 2000, 2002, 2500, 2503]
    y[rows] += 300.0
    assert np.flatnonzero(spikes(y)).tolist() == rows


def test_an_end_is_bent_only_where_the_inside_never_is():
    y = np.sin(np.arange(2000) * 0.2) + 1e-3 * np.random.default_rng(3).standard_normal(2000)
    assert not bent_ends(y).any()
    y[-3:] += (0.5, 1.0, 2.0)
    assert np.flatnonzero(bent_ends(y)).tolist() == [1995, 1996, 1997, 1998, 1999]
    y[np.arange(100, 1900, 100)] += 2.0
    assert not bent_ends(y).any()


@pytest.mark.parametrize("ends", [[27.0, 12.0, 7.0], [4.0, 2.0, 1.0]])
def test_an_end_that_is_bent_within_the_noise_of_its_differences_shows_beside_the_model(
    clean, ends
):
    """Third differences of noise are as large as 40 of its deviations."""
    first, second, third = (record(seed=seed) for seed in (1, 2, 3))
    y = second.channels["damper_force"].copy()
    y[-3:] += FORCE_NOISE * np.array(ends[::-1])
    bent_one = changed(second, "damper_force", y)
    assert marked(bent_one).wild == {}
    found = opened(Dataset.of([first, bent_one, third]), load_model(GUO)).problem
    wild, end = np.flatnonzero(found.wild).tolist(), 2 * y.size
    said = "4 samples of damper_force are bent at an end beside the model: no weight"
    far = ends[0] > 10.0
    assert (wild, found.beside) == ((list(range(end - 4, end)), 4) if far else ([], 0))
    assert (said in found.notes) is far


@pytest.mark.parametrize("lowest", [-1.2, -1.0])
def test_a_short_run_at_the_other_end_of_the_range_of_a_load_cell_is_clipped_too(lowest):
    t = np.arange(4000) * 0.01
    moving = np.sin(2.0 * np.pi * 0.7 * t) + 0.4 * np.sin(2.0 * np.pi * 2.3 * t)
    force = np.minimum(moving, 1.1)
    force[1000:1021] = 1.25 - 0.25 * np.linspace(-1.0, 1.0, 21) ** 2
    force = np.round(np.clip(force, lowest, 1.2), 3)
    low, high = force == lowest, force == 1.2
    assert high.sum() == 9
    assert np.array_equal(clipped_runs(force, [moving]), low | (high & (lowest == -1.2)))


def test_a_filter_that_bends_all_ends_makes_no_lag_of_the_velocity():
    """A deflection of zero there shows nothing; with the ends in it the velocity lags by 0.5 ms, 17 deviations."""
    ends, rng, t = np.array([0.5, 0.86, 0.97]), np.random.default_rng(1), np.arange(2000) * DT
    w = 2.0 * np.pi * np.array([0.45, 1.3])
    x, v = np.sin(np.outer(t, w)) @ (0.04, 0.01), np.cos(np.outer(t, w)) @ (w * (0.04, 0.01))
    y = {
        "deflection": x + 2e-5 * rng.standard_normal(t.size),
        "deflection_velocity": v + 2e-3 * rng.standard_normal(t.size),
        "damper_force": 800.0 * v + rng.standard_normal(t.size),
    }
    for channel in y.values():
        channel[:3] *= ends
        channel[-3:] *= ends[::-1]
    lag, sd = prepare(Dataset.of([marked(Record("slow", t, y))])).velocity_lag
    assert abs(lag) < 4.0 * sd


def test_a_load_cell_at_the_end_of_its_range_is_no_steady_tone():
    rng, n = np.random.default_rng(3), 4000
    wild = np.zeros(n, dtype=np.bool_)
    wild[1800:1900] = True
    left = rng.standard_normal(n) + 800.0 * wild
    seen = SimpleNamespace(motion=SimpleNamespace(starts=np.array([0, n]), dt=0.002), wild=wild)
    seen.with_weight = partial(Problem.with_weight, seen)
    assert spectral_line(seen, left) == (0.0, 0.0, 0.0)
    tone = left + 2.0 * np.sin(2.0 * np.pi * 3.0 * 0.002 * np.arange(n))
    assert spectral_line(seen, tone)[0] == pytest.approx(3.0, abs=0.2)


@pytest.mark.parametrize(("kind", "check", "rows"), [
    ("struck", "spikes", (1234, 1234)), ("cut_below", "held", (1000, 1079)), ("hangs", "held", (1500, 1559)),
])  # fmt: skip
def test_a_finding_says_from_when_to_when(clean, kind, check, rows):
    spoilt = KINDS[kind](clean[None])
    late = replace(spoilt, t=spoilt.t + 100.0)
    for given in (spoilt, late):
        found = [f for f in findings(given) if f.check == check and f.spans]
        assert [f.spans for f in found] == [(tuple(float(given.t[k]) for k in rows),)]
        assert found[0].as_json()["spans"] == found[0].spans


def test_lost_samples_are_found_where_they_are_missing(clean):
    given = clean[None]
    t = np.delete(given.t, slice(800, 810))
    (found,) = [
        f for f in time_findings(replace(given, timing=timing_of(t))) if f.check == "dropouts"
    ]
    assert found.spans == ((float(given.t[799]), float(given.t[810])),)


def test_many_spans_become_few_that_hold_all_of_them():
    t = np.arange(3000.0)
    mask = np.arange(3000) % 3 == 0
    mask[1200:1500] = False
    spans = spans_of(t, mask)
    assert len(spans) == MOST
    covered = np.logical_or.reduce([(t >= a) & (t <= b) for a, b in spans])
    assert covered[mask].all()
    assert not covered[1200:1500].any(), "the widest pause stays one"
