"""Faults put into a sound record are found, named and gated; what is sound passes."""

import json
from dataclasses import replace

import numpy as np
import pytest
from er_model_lab.cli.app import app
from er_model_lab.preflight.check import findings, gate, preflight
from er_model_lab.preflight.derivative import relate
from er_model_lab.preflight.excitation import CELLS, needs
from er_model_lab.preflight.samples import clipped
from er_models.catalogue import CATALOGUE
from er_models.effect import REGIONS
from er_models.errors import InputError
from er_records.load import load
from er_records.record import Record
from er_records.timing import timing_of
from lab_help import DT, GUO, imposed
from typer.testing import CliRunner

ACCELERATIONS = ("sprung_acceleration", "unsprung_acceleration")


@pytest.fixture(scope="module")
def sound():
    rng = np.random.default_rng(5)
    n = 4000
    x, v, a, u = imposed(rng, n)
    t = np.arange(n) * DT
    wheel = 2e-3 * np.sin(9.0 * t)
    channels = {
        "deflection": x + 2e-5 * rng.standard_normal(n),
        "deflection_velocity": v + 1e-3 * rng.standard_normal(n),
        "duty": u,
        "damper_force": 70.0 * v + 20.0 * u * np.tanh(v / 2e-3) + 0.15 * rng.standard_normal(n),
        "unsprung_acceleration": -81.0 * wheel + 0.025 * rng.standard_normal(n),
        "sprung_acceleration": a - 81.0 * wheel + 0.025 * rng.standard_normal(n),
        "road": wheel,
    }
    return Record("run", t, channels, source="run.csv", timing=timing_of(t))


def with_(record, without=(), **changed):
    channels = {**record.channels, **changed}
    return replace(record, channels={k: y for k, y in channels.items() if k not in without})


def bad(record):
    return [
        (f.level, f.check, f.channel) for f in findings(record) if f.level in ("fail", "warning")
    ]


def test_a_sound_record_passes(sound):
    assert bad(sound) == []
    assert {f.check for f in findings(sound)} == {
        "sampling",
        "dropouts",
        "held",
        "clipping",
        "units",
    }


def test_a_derivative_is_recognised_with_factor_sign_and_delay():
    rng = np.random.default_rng(0)
    n, dt = 6000, 0.005
    x, v, _, _ = imposed(rng, n)
    late = np.interp(np.arange(n) * dt - 0.0034, np.arange(n) * dt, v)
    found = relate(
        x + 2e-5 * rng.standard_normal(n), -2.5 * late + 1e-3 * rng.standard_normal(n), 1, dt
    )
    assert found.gain == pytest.approx(-2.5, abs=max(4.0 * found.gain_sd, 0.03))
    assert found.delay == pytest.approx(0.0034, abs=max(5.0 * found.delay_sd, 1e-4))
    assert relate(rng.standard_normal(n), rng.standard_normal(n), 1, dt) is None


def slow(rate, seconds, frequencies, noise=1.0):
    """A record without accelerations; noise: of 20 um and 1 mm/s."""
    rng = np.random.default_rng(11)
    t = np.arange(rate * seconds) / rate
    w, phase = (
        2.0 * np.pi * np.asarray(frequencies)[:, None],
        rng.uniform(0.0, 6.0, (len(frequencies), 1)),
    )
    x = np.sum(8e-3 / w * np.sin(w * t + phase), axis=0)
    v = np.sum(8e-3 * np.cos(w * t + phase), axis=0)
    channels = {
        "deflection": 0.02 + x + 2e-5 * noise * rng.standard_normal(t.size),
        "deflection_velocity": v + 1e-3 * noise * rng.standard_normal(t.size),
    }
    return Record("run", t, channels, source="run.csv", timing=timing_of(t))


@pytest.mark.slow
@pytest.mark.parametrize("rate", [100, 200, 1000, 2000])
@pytest.mark.parametrize(
    ("seconds", "frequencies"), [(16, (0.3, 0.7, 1.1, 2.3, 4.1)), (8, (0.4, 0.9)), (16, (0.25,))]
)
def test_slow_motion_is_checked_at_every_rate(rate, seconds, frequencies):
    good = slow(rate, seconds, frequencies)
    assert not [b for b in bad(good) if b[1] != "motion"]
    x, v = good.channels.values()
    for wrong in ({"deflection": -x}, {"deflection_velocity": 100.0 * v}):
        fails = [b[:2] for b in bad(with_(good, **wrong)) if b[0] == "fail"]
        assert fails == [("fail", "units")]


def test_channels_that_cannot_be_compared_are_said_to_be_unchecked(sound):
    still = slow(1000, 8, ())
    assert bad(still) == [("warning", "units", "")]
    lone = with_(sound, deflection=np.random.default_rng(3).standard_normal(len(sound)))
    assert ("warning", "units", "deflection") in bad(lone)
    found = [f for f in findings(with_(still, ("deflection",))) if f.check == "units"]
    assert [f.level for f in found] == ["note"]


@pytest.mark.parametrize("order", [1, 2])
def test_fast_tones_are_not_taken_for_a_gain(order):
    w, t = 2.0 * np.pi * 30.0, np.arange(4000) * 0.005
    x = np.sin(w * t) + 1e-4 * np.random.default_rng(2).standard_normal(t.size)
    derivative = np.real((1j * w) ** order * np.exp(1j * (w * t - np.pi / 2.0)))
    found = relate(x, derivative, order, 0.005)
    assert found.gain == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(
    ("channel", "factor", "without", "unit"),
    [
        ("deflection", 1e3, (), "mm"), ("deflection", 1e3, ACCELERATIONS, "mm"),
        ("deflection_velocity", 1e3, (), "mm/s"), ("deflection_velocity", 1e2, ACCELERATIONS, "cm/s"),
        ("deflection", 1.0 / 0.0254, (), "inches"), ("deflection", -1.0, (), "opposite sign"),
        ("road", 1e3, (), "mm"),
    ],
)  # fmt: skip
def test_a_wrong_unit_is_named_with_its_channel(sound, channel, factor, without, unit):
    record = with_(sound, without, **{channel: factor * sound.channels[channel]})
    fails = [f for f in findings(record) if f.level == "fail"]
    assert [f.channel for f in fails] == [channel]
    assert unit in fails[0].found


def test_accelerations_in_g_are_named(sound):
    record = with_(sound, ("road",), **{c: sound.channels[c] / 9.80665 for c in ACCELERATIONS})
    fails = [f for f in findings(record) if f.level == "fail"]
    assert len(fails) == 1
    assert "looks like g " in fails[0].found


def faults(s):
    c = s.channels
    t, x, v, f = s.t, c["deflection"], c["deflection_velocity"], c["damper_force"]
    return {
        ("warning", "units", "deflection_velocity"): {"deflection_velocity": 1.05 * v},
        ("warning", "clock", "deflection_velocity"): {"deflection_velocity": np.roll(v, 1)},
        ("warning", "bias", "deflection_velocity"): {"deflection_velocity": v + 2e-3},
        ("fail", "bias", "sprung_acceleration"): {"sprung_acceleration": c["sprung_acceleration"] + 9.81},
        ("fail", "power", "damper_force"): {"damper_force": -f},
        ("fail", "clipping", "damper_force"): {"damper_force": np.clip(f, -9.0, 9.0)},
        ("warning", "held", "damper_force"): {"damper_force": np.repeat(f[::4], 4)},
        ("warning", "held", "deflection"): {"deflection": np.where((t > 5) & (t < 6), x[1000], x)},
        ("fail", "held", "damper_force"): {"damper_force": np.zeros_like(f)},
    }  # fmt: skip


def test_every_other_fault_is_found_and_no_second_one(sound):
    for expected, changed in faults(sound).items():
        assert bad(with_(sound, **changed)) == [expected]


@pytest.mark.parametrize(
    ("without", "level"),
    [((), "fail"), ((*ACCELERATIONS, "road", "deflection_velocity"), "warning")],
)
def test_a_deflection_that_stands_still_while_the_force_changes_may_be_a_damper_that_sticks(
    sound, without, level
):
    x = sound.channels["deflection"]
    stuck = np.where((sound.t % 2.0) < 0.6, x[1000], x)
    found = [f for f in findings(with_(sound, without, deflection=stuck)) if f.check == "held"]
    assert [(f.level, f.channel) for f in found] == [(level, "deflection")]


def test_a_coarse_converter_is_neither_held_nor_clipped(sound):
    coarse = {
        "deflection": np.round(sound.channels["deflection"] / 5e-5) * 5e-5,
        "damper_force": np.round(2.0 * sound.channels["damper_force"]) / 2.0,
    }
    assert bad(with_(sound, **coarse)) == []


def test_rest_of_a_coarse_converter_is_no_clipping_where_uneven_times_were_made_even(tmp_path):
    """Between two samples the resampled encoder moves by less than its step."""
    rng = np.random.default_rng(2)
    t = np.cumsum(DT * rng.uniform(0.7, 1.3, 4000))
    x = np.tanh(2.5 * np.sin(2.0 * np.pi * 0.4 * t) - 0.2)
    force = 40.0 * np.gradient(x, t) + 10.0 * np.sin(9.0 * t) + rng.normal(0.0, 0.5, t.size)
    columns = {"t": t, "deflection": np.round(x / 0.004) * 2e-4, "damper_force": force}
    path = tmp_path / "run.csv"
    np.savetxt(
        path,
        np.column_stack([*columns.values()]),
        delimiter=",",
        header=",".join(columns),
        comments="",
    )
    (record,) = load([path])
    assert "resampled" in " ".join(record.notes)
    assert "clipping" not in {f.check for f in findings(record) if f.level != "ok"}


def test_a_flat_top_that_noise_breaks_into_short_runs_is_clipped_as_a_whole():
    """At 10 kHz the force crosses the end of a load cell's range often before it stays there."""
    t = np.arange(60_000) * 1e-4
    swing = np.sin(2.0 * np.pi * 0.5 * t)
    force = 104.0 * swing + np.random.default_rng(4).normal(0.0, 0.6, t.size)
    cut = np.clip(force, -100.0, 100.0)
    found = clipped(cut, [0.5 * swing])
    runs_of = np.diff(np.flatnonzero(np.diff(np.r_[0, found, 0])))[::2]
    assert np.median(runs_of) < 10
    for end in (-100.0, 100.0):
        assert found[cut == end].mean() > 0.9
    assert np.all(np.abs(cut[found]) == 100.0)


def test_rest_at_the_end_of_the_stroke_is_no_clipping(sound):
    n = len(sound)
    x = 5e-3 * np.clip(2.0 * np.sin(2.0 * np.pi * 0.5 * sound.t), -1.0, 1.0)
    v = np.gradient(x, DT)
    record = with_(
        sound, (*ACCELERATIONS, "road"), deflection=x, deflection_velocity=v, damper_force=70.0 * v
    )
    assert not [b for b in bad(record) if b[1] == "clipping"]
    assert n == len(record)


def test_lost_samples_and_jitter_are_counted_from_the_times_as_stored(sound, tmp_path):
    rng = np.random.default_rng(1)
    keep = np.ones(len(sound), bool)
    keep[1000:1003] = keep[2000:2002] = False
    table = np.column_stack(
        [sound.t + 5e-4 * rng.uniform(-1, 1, len(sound)), *sound.channels.values()]
    )[keep]
    path = tmp_path / "run.csv"
    np.savetxt(path, table, delimiter=",", header=",".join(("t", *sound.channels)), comments="")
    found = {f.check: f for f in findings(load([path])[0])}
    assert "5 lost" in found["dropouts"].found
    assert found["sampling"].found.startswith(("199", "200"))
    assert load([path])[0].timing.jitter == pytest.approx(5e-4 * np.sqrt(2.0 / 3.0), rel=0.1)


def test_coverage_says_which_effect_lacks_what(sound):
    whole = preflight([sound])
    assert "coulomb_friction" not in whole.missing
    assert "field_exponent" not in whole.missing
    assert "minutes" in whole.missing["self_heating"]
    still = preflight([with_(sound, duty=np.zeros(len(sound)))])
    assert still.missing["field_exponent"] == ("duty_levels",)
    assert set(still.missing["dead_time"]) == {"duty_rises", "duty_falls"}
    up = np.maximum(sound.channels["deflection"], -1e-3)
    assert "far_compression" in preflight([with_(sound, deflection=up)]).missing["end_stop"]
    levels = [with_(sound, duty=np.full(len(sound), u)) for u in (0.0, 0.1, 0.2, 0.3)]
    assert "field_exponent" not in preflight(levels).missing
    total = sum(float(np.sum(m.seconds)) for m in whole.maps if m.y)
    assert total == pytest.approx(2 * len(sound) * DT, rel=1e-6)


def test_every_named_need_exists_and_names_an_effect():
    assert set(CELLS) == set(REGIONS)
    assert needs(CATALOGUE["preload"]) == ()
    assert needs(CATALOGUE["dead_time"]) == ("duty_rises", "duty_falls")
    assert all(set(needs(e)) <= set(CELLS) for e in CATALOGUE.effects)
    assert set(needs(CATALOGUE["field_viscosity"])) >= {"fast_high_duty", "duty_levels"}


def passed(*records, anyway=False):
    """Records that passed the gate."""
    return gate(preflight(records), records, anyway=anyway)


def test_the_gate_stops_unless_asked_to_go_on(sound):
    wrong = with_(sound, deflection=1e3 * sound.channels["deflection"])
    wrong = replace(wrong, name="wrong")
    with pytest.raises(
        InputError,
        match=r"run.csv: deflection: units: expected m, found .*mm .*anyway=True goes on",
    ):
        passed(sound, wrong)
    used = passed(sound, wrong, anyway=True)
    assert [r.complete for r in used] == [True, False]
    assert any("looks like mm" in n for n in used[1].notes)
    assert passed(sound)[0] is sound


def test_the_command_reports_and_ends_with_two_when_data_are_unusable(sound, tmp_path):
    for name, factor, status in (("good", 1.0, 0), ("bad", 1.0 / 0.0254, 2)):
        path = tmp_path / f"{name}.csv"
        channels = {**sound.channels, "deflection": factor * sound.channels["deflection"]}
        np.savetxt(
            path, np.column_stack([sound.t, *channels.values()]), delimiter=",",
            header=",".join(("t", *channels)), comments="",
        )  # fmt: skip
        words = [
            "check",
            path,
            "--model",
            GUO,
            "--json",
            tmp_path / "r.json",
            "--report",
            tmp_path / name,
        ]
        done = CliRunner().invoke(app, [str(w) for w in words])
        assert done.exit_code == status, done.output
        found = json.loads((tmp_path / "r.json").read_text())["preflight"]
        assert found["passed"] is (status == 0)
        assert found["reach"]["known_from"] == "the model's rig"
        assert max(len(line) for line in done.output.splitlines()[:-1]) <= 100
        assert len(done.output.splitlines()) <= 40
        assert (tmp_path / name / "figures" / "coverage.svg").exists()
    assert "looks like inches" in done.output
    words = ["compare", path, "--model", GUO]
    refused = CliRunner().invoke(app, [str(w) for w in words])
    assert refused.exit_code == 2
    assert len(refused.output.strip().splitlines()) == 1
    assert refused.output.strip().endswith("--anyway goes on")
