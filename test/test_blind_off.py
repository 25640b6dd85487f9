"""Benches other than the nominal one change what they say they change, and what is said of them is judged as stated."""

from dataclasses import replace

import numpy as np
import pytest
from er_model_lab.diagnosis.candidates import baseline, refit
from er_model_lab.diagnosis.null import simulate_null
from er_model_lab.diagnosis.passing import passes, threshold
from er_model_lab.level.damper import opened
from er_model_lab.verbs.load import load
from er_models.files import load_model

from test.blind.calibrate import clean_records
from test.blind.errors import BlindError
from test.blind.generator import make_case
from test.blind.slots import BIAS, OUT_HUM
from test.blind_score import __main__ as program
from test.blind_score.cases import Asked, few
from test.blind_score.conditions import CONDITIONS, changed_case, measured, resampled
from test.blind_score.off import off_page, worth
from test.blind_score.rows import read
from test.blind_score.run import MODEL

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    """A short case whose force is filtered."""
    folder = tmp_path_factory.mktemp("case") / "data"
    return make_case("force_lag", 5, out=folder, n_records=1, seconds=4.0)


def columns_of(case, name, folder):
    """What a bench writes of a case."""
    condition = CONDITIONS[name]
    path = measured(changed_case(case, condition, 1), condition, 1, folder / name) / "record_1.csv"
    head = path.read_text().splitlines()[0].split(",")
    return dict(zip(head, np.loadtxt(path, delimiter=",", skiprows=1).T, strict=True))


def test_another_rate_shows_the_same_motion(case):
    (motion,) = case.motions
    on_grid = replace(motion, duty=np.repeat(motion.duty[::2], 2))
    (nominal,) = clean_records((on_grid,), case.table, case.base, case.seconds)
    for rate, every in ((200.0, 1), (100.0, 2)):
        found = resampled(motion, case, rate)
        for name, samples in nominal.items():
            np.testing.assert_allclose(found[name], samples[::every], rtol=1e-9, atol=1e-9)
    fine, coarse = resampled(motion, case, 500.0), resampled(motion, case, 100.0)
    assert fine["t"].size == 2000
    for name, samples in coarse.items():
        np.testing.assert_allclose(fine[name][::5], samples, rtol=1e-9, atol=1e-9)


def test_a_bias_is_there_at_any_rate(case):
    table = np.zeros_like(case.table)
    table[BIAS, :2] = 0.5, -2.0
    hidden = replace(
        case.hidden[0], effect=replace(case.hidden[0].effect, slot=BIAS), row=table[BIAS]
    )
    with_bias, without = replace(case, hidden=(hidden,)), replace(case, hidden=())
    (motion,) = case.motions
    for rate in (100.0, 500.0):
        found, clean = (resampled(motion, c, rate) for c in (with_bias, without))
        for name, bias in (("sprung_acceleration", 0.5), ("unsprung_acceleration", -1.0)):
            np.testing.assert_allclose(found[name] - clean[name], bias, rtol=0.0, atol=1e-12)


def test_an_effect_that_is_made_of_samples_has_no_other_rate(case):
    hum = case.hidden[0]
    row = replace(hum, effect=replace(hum.effect, slot=OUT_HUM))
    with pytest.raises(BlindError, match="between samples"):
        resampled(case.motions[0], replace(case, hidden=(row,)), 100.0)


def test_benches_change_what_they_say(case, tmp_path):
    nominal = columns_of(case, "nominal", tmp_path)
    late = columns_of(case, "force_late", tmp_path)
    np.testing.assert_array_equal(late["damper_force"][1:], nominal["damper_force"][:-1])
    np.testing.assert_array_equal(late["deflection"], nominal["deflection"])
    assert "deflection_velocity" not in columns_of(case, "deflection_only", tmp_path)
    large = columns_of(case, "large", tmp_path)
    np.testing.assert_allclose(large["damper_force"], 30.0 * nominal["damper_force"], rtol=1e-8)
    quiet = (
        columns_of(case, "force_quiet", tmp_path)["damper_force"] - case.clean[0]["damper_force"]
    )
    assert np.std(quiet) == pytest.approx(0.03, rel=0.1)
    t = columns_of(case, "stamps", tmp_path)["t"]
    assert (np.diff(t) >= 0.0).all()
    assert 0.0 < np.mean(np.diff(t) == 0.0) < 0.02
    duty = columns_of(case, "few_steps", tmp_path)["duty"]
    assert set(duty) <= {0.05, 0.13, 0.21, 0.3}
    x = columns_of(case, "narrow_band", tmp_path)["deflection"]
    power = np.abs(np.fft.rfft((x - x.mean()) * np.hanning(x.size))) ** 2
    slow = np.fft.rfftfreq(x.size, 0.005) < 3.5
    assert power[slow].sum() > 0.95 * power.sum()


@pytest.mark.parametrize("bench", ["deflection_only", "no_accelerations"])
def test_bends_that_no_accelerometer_shows_name_nothing(bench, tmp_path):
    """Fusion rounds them off the same way each time, so that its errors look like effects beyond chance."""
    complete = make_case(None, 4, out=tmp_path / "made", n_records=1, seconds=24.0)
    data = measured(
        changed_case(complete, CONDITIONS[bench], 1), CONDITIONS[bench], 1, tmp_path / "seen"
    )
    model = load_model(MODEL)
    problem = opened(load(data), model).problem
    base = baseline(model, problem)
    rivals = [
        refit(base, model.catalogue[e], problem)
        for e in ("force_delay", "field_viscosity", "velocity_lag")
    ]
    null = simulate_null(base, rivals, problem, 0)
    assert not any(passes(base, c, threshold(null, np.sqrt(base.mse))) for c in rivals)


def off_row(condition, kind, hidden, names, verdict="missing_effect", **more):
    return {
        "key": "k", "condition": condition, "kind": kind, "hidden": hidden, "names": names, "verdict": verdict,
        "alternatives": [], "notes": [], "rise_together": 0.5, **more,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("row", "word"),
    [
        (off_row("nominal", "singles", ["a"], ["a"]), "right"),
        (off_row("nominal", "singles", ["a"], ["a", "b"]), "wrong"),
        (off_row("nominal", "singles", ["a"], ["b"], "ambiguous"), "modest"),
        (off_row("nominal", "singles", ["a"], [], "adequate"), "modest"),
        (off_row("nominal", "complete", [], ["b"], "ambiguous"), "wrong"),
        (off_row("nominal", "complete", [], [], "adequate"), "right"),
        (off_row("nominal", "outside", ["outside:x"], ["b"]), "wrong"),
        (off_row("nominal", "outside", ["outside:x"], [], "unknown_effect"), "right"),
        (off_row("nominal", "complete", [], [], "unknown_effect"), "modest"),
        (off_row("nominal", "complete", [], [], "insufficient_data"), "modest"),
        (off_row("base_bingham", "complete", [], ["b"], "partial"), "modest"),
        (off_row("base_bingham", "complete", [], ["b"]), "wrong"),
        (off_row("force_late", "complete", ["force_delay"], ["force_delay"]), "right"),
        (off_row("force_late", "singles", ["a", "force_delay"], ["force_delay", "a"]), "right"),
        (off_row("force_late", "singles", ["a", "force_delay"], ["force_delay"], "partial"), "modest"),
        (off_row("nominal", "singles", ["a"], [], failed="ValueError: x"), "failed"),
        (off_row("unit_mm", "complete", [], [], failed="deflection looks like mm"), "right"),
        (off_row("unit_mm", "complete", [], [], failed="ValueError: x"), "wrong"),
        (off_row("unit_kN", "complete", [], [], "adequate"), "wrong"),
        (off_row("unit_kN", "complete", [], [], "adequate", notes=["or of another unit"]), "right"),
    ],
)  # fmt: skip
def test_what_is_said_off_the_nominal_condition_is_judged(row, word):
    assert worth(row) == word
    assert ("| k |" in off_page([row], "heading")) == (word != "right")


def test_every_condition_is_asked_the_same_few_cases(tmp_path, monkeypatch, capsys):
    assert [a.kind for a in few(3)] == ["singles"] * 6 + ["complete"] * 2 + ["outside"]

    def fake(asked: Asked, size=None):
        row = off_row(asked.condition, asked.kind, list(asked.hidden), list(asked.hidden))
        return {**row, "key": asked.key}

    monkeypatch.setattr(program, "score_off", fake)
    out = tmp_path / "r.jsonl"
    words = [
        "--condition",
        "rate_100",
        "large",
        "--seeds",
        "3",
        "--workers",
        "1",
        "--results",
        str(out),
    ]
    assert program.main(words) == 0
    keys = [r["key"] for r in read(out)]
    assert len(set(keys)) == 18
    assert keys[0].removeprefix("rate_100/") == keys[9].removeprefix("large/")
    assert (
        "| `large` | force 30 times, stroke 3 times | 9 | 8 | 1 | 0 | 0 |"
        in capsys.readouterr().out
    )
