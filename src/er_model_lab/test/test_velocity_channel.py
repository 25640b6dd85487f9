"""Lag and gain of the velocity channel: who sees them, what they explain, and that a written model keeps them."""

from dataclasses import replace

import numpy as np
import pytest
from er_model_lab.diagnosis.candidates import baseline, missing
from er_model_lab.diagnosis.investigation import one_effect
from er_model_lab.diagnosis.rule import RULE
from er_model_lab.fitting.velocity_channel import put_back
from er_model_lab.level.damper import DamperLevel, _as_measured, _with_lag, opened
from er_model_lab.level.investigate import Question, added
from er_model_lab.level.study import Study
from er_model_lab.preflight.check import preflight
from er_model_lab.problem import stretches
from er_model_lab.problem.prepare import prepare
from er_model_lab.results.diagnosis import diagnosis_json
from er_models.errors import MissingChannel
from er_models.files import load_model
from er_models.prediction import motion, predict
from er_records.dataset import Dataset
from er_records.record import Record
from lab_help import DT, EVIDENCE, FORCE_NOISE, GUO, asked, imposed

ACCELERATIONS = ("sprung_acceleration", "unsprung_acceleration")


def record(seconds=14.0, lag=0.0, gain=1.0, without=(), seed=1, truth=None, name="run"):
    """A damper on an imposed motion, whose velocity channel lags and is out of scale."""
    rng, n = np.random.default_rng(seed), round(seconds / DT)
    x, v, a, u = imposed(rng, n)
    force = predict(truth or load_model(GUO), motion(DT, x, v, u, a))
    channels = {
        "deflection": x + 2e-5 * rng.standard_normal(n), "duty": u,
        "deflection_velocity": gain * (v - lag * a + 1e-3 * rng.standard_normal(n)),
        "sprung_acceleration": a + 0.025 * rng.standard_normal(n),
        "unsprung_acceleration": 0.025 * rng.standard_normal(n),
        "damper_force": force + FORCE_NOISE * rng.standard_normal(n),
    }  # fmt: skip
    kept = {c: y for c, y in channels.items() if c not in without}
    return Record(name, np.arange(n) * DT, kept)


def add_effect(data, model, effect):
    """The study of one effect, and the model that it ends with."""
    study = added(Question(data, model, DamperLevel(), preflight(data.records)), effect)
    return study, DamperLevel().finished(study, 0)


def rms_error(data, model):
    """What is left of the data without any refit [N]."""
    found = opened(data, model)
    return np.std(found.given[found.problem.used])


@pytest.mark.parametrize("lag", [0.0, 0.004])
def test_the_lag_can_be_added_whether_it_is_there_or_not(lag):
    data = Dataset.of([record(lag=lag)])
    study, found = add_effect(data, load_model(GUO), "velocity_lag")
    value, sd = found.value("velocity_lag", "T_v"), found.deviations["velocity_lag"]["T_v"]
    assert sd < 5e-5
    assert abs(value - lag) < max(4.0 * sd, 0.03 * lag)
    assert ("velocity_lag" in study.diagnosis.effects) is (lag > 0.0)
    (told,) = diagnosis_json(study, found)["candidates"]
    assert told["status"] == ("present" if lag else "absent")
    assert opened(data, found).lag is None
    assert rms_error(data, found) < 1.1 * FORCE_NOISE


def test_another_effect_added_says_that_a_lag_was_undone():
    study, _ = add_effect(Dataset.of([record(lag=0.004)]), load_model(GUO), "preload")
    assert any("lags deflection and accelerometers by 3.9" in n for n in study.problem.notes)
    plain, _ = add_effect(Dataset.of([record()]), load_model(GUO), "preload")
    assert not any("lags" in n for n in plain.problem.notes)


def test_of_a_velocity_alone_the_lag_is_read_off_the_force():
    only = Dataset.of([record(lag=0.004, without=("deflection", *ACCELERATIONS))])
    _, found = add_effect(only, load_model(GUO), "velocity_lag")
    assert found.value("velocity_lag", "T_v") == pytest.approx(0.004, rel=0.2)
    assert rms_error(only, found) < 0.8 * rms_error(only, load_model(GUO))


def test_a_channel_that_was_not_measured_does_not_lag():
    model, blind = load_model(GUO), record(without=("deflection_velocity", *ACCELERATIONS))
    assert "velocity_lag" not in {e.name for e in missing(model, prepare(Dataset.of([blind])))}
    with pytest.raises(
        MissingChannel, match="'deflection_velocity' is needed to see that it lags"
    ):
        add_effect(Dataset.of([blind]), model, "velocity_lag")


def test_one_record_that_can_show_a_lag_is_enough():
    blind = record(without=("deflection_velocity",), seed=2, name="blind", seconds=20.0)
    problem = prepare(Dataset.of([blind, record(lag=0.004)]))
    assert problem.velocity_lag[0] == pytest.approx(0.004, rel=0.05)
    assert "velocity_lag" not in {e.name for e in missing(load_model(GUO), problem)}


@pytest.mark.parametrize("heat", [False, True])
def test_a_model_that_is_written_keeps_gain_and_lag_of_the_velocity(heat, monkeypatch):
    given = load_model(GUO).with_effect("velocity_gain", {"g_v": 1.1})
    given = put_back(given, given.with_effect("velocity_lag", {"T_v": 0.004}))
    effect, data = "coulomb_friction", record(lag=0.004, gain=1.1)
    if heat:
        monkeypatch.setattr(stretches, "LONG", 2500)
        monkeypatch.setattr(stretches, "USED", 2400)
        effect = "self_heating"
    _, found = add_effect(stretches.shortened(Dataset.of([data])), given, effect)
    for name in ("velocity_gain", "velocity_lag"):
        assert found.effects[name] == given.effects[name]
    assert effect in found.effects


def test_the_error_before_is_that_of_the_fused_motion_where_no_velocity_was_measured():
    model = load_model(GUO)
    blind = record(without=("deflection_velocity",), seed=2, name="blind")
    seen = opened(Dataset.of([record(lag=0.006), blind]), model)
    problem = seen.problem
    before, after = _as_measured(seen).fit.residual, baseline(model, problem).fit.residual
    i = int(problem.motion.starts[1])
    used = problem.used
    assert np.std(before[:i][used[:i]]) > 1.5 * np.std(after[:i][used[:i]])
    assert np.std(before[i:][used[i:]]) < 3.0 * np.std(after[i:][used[i:]])
    assert seen.lag[0] == pytest.approx(0.006, rel=0.05)


@pytest.fixture(scope="module")
def plain():
    """A model, six seconds of it, and a diagnosis that tried nothing."""
    model = load_model(GUO)
    problem = opened(Dataset.of([record(seconds=6.0)]), model).problem
    return model, problem, one_effect(model, problem, None, 0)


@pytest.mark.parametrize(
    ("before", "explained", "verdict"),
    [("adequate", 0.01, "missing_effect"), ("insufficient_data", 0.9, "ambiguous"),
     ("unknown_effect", 0.1, "unknown_effect"), ("unknown_effect", 0.5, "partial"),
     ("partial", 0.01, "partial"), ("missing_effect", 0.01, "missing_effect")],
)  # fmt: skip
def test_a_lag_makes_up_for_nothing_else_that_is_unknown(before, explained, verdict, plain):
    model, problem, found = plain
    mse = found.best.mse
    limit = 0.5 * mse
    floor = replace(found.floor, floor=float(np.sqrt(limit)))
    found = replace(found, verdict=before, evidence=EVIDENCE[before], floor=floor)
    wanted = replace(found.base, mse=(mse - explained * limit) / (1.0 - explained))
    whole = _with_lag(found, wanted, (0.004, 1e-5), RULE)
    assert whole.explained == pytest.approx(explained, abs=1e-6)
    assert whole.verdict == verdict
    assert whole.effects == ("velocity_lag",)
    study = Study(asked(model, problem, (0.004, 1e-5)), whole, wanted)
    assert DamperLevel().finished(study, 0).value("velocity_lag", "T_v") == 0.004
