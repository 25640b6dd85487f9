"""Gains in the lab: never tried, said to be unknowable, and kept where a calibration put them into the model."""

import json
from dataclasses import replace

import numpy as np
import pytest
from er_model_lab.cli.app import app
from er_model_lab.diagnosis.candidates import baseline, missing
from er_model_lab.diagnosis.restarts import restarts, terms
from er_model_lab.fitting.velocity_channel import on_fused
from er_model_lab.level.damper import opened
from er_model_lab.problem.forward import free_parameters
from er_model_lab.verbs.load import load
from er_models.catalogue import CATALOGUE
from er_models.files import load_model, save_model
from typer.testing import CliRunner

from test.conftest import ROOT
from test.sample import write_sample

DAMPER, CAR = (
    ROOT / "config" / name
    for name in ("dampers/inove_guo.yaml", "vehicles/inove_quarter_car.yaml")
)
GAINS = {"force_gain": {"g_F": 1.05}, "velocity_gain": {"g_v": 1.1}, "duty_gain": {"g_u": 0.9}}


def lab(*words):
    return CliRunner().invoke(app, [str(w) for w in words])


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Twelve seconds of the Guo damper as its model file has it."""
    path = tmp_path_factory.mktemp("gains") / "run.csv"
    return write_sample(path, seed=2, seconds=12.0, truth=load_model(DAMPER))


def out_of_scale(data, path, column, factor):
    """The data with one channel out of scale; a velocity without the channels that would outvote it."""
    rows = np.loadtxt(data, delimiter=",", skiprows=1)
    names = data.read_text().splitlines()[0].split(",")
    rows[:, names.index(column)] *= factor
    others = ("deflection", "sprung_acceleration", "unsprung_acceleration")
    kept = [n for n in names if n not in others or column != "deflection_velocity"]
    rows = rows[:, [names.index(n) for n in kept]]
    np.savetxt(path, rows, delimiter=",", header=",".join(kept), comments="")
    return path


def error(data, model):
    """Error of a model as it is [N]."""
    found = opened(load(data), model)
    return float(np.sqrt(np.mean(found.given[found.problem.used] ** 2)))


@pytest.mark.parametrize(
    ("gain", "column", "factor"),
    [("force_gain", "damper_force", 1.05), ("velocity_gain", "deflection_velocity", 1.1),
     ("duty_gain", "duty", 1 / 0.9)],
)  # fmt: skip
def test_a_known_gain_is_undone(gain, column, factor, data, tmp_path):
    """A channel out of scale, and the model with that gain: as good as the true channel with the plain model."""
    true = out_of_scale(data, tmp_path / "true.csv", column, 1.0)
    odd = out_of_scale(data, tmp_path / "odd.csv", column, factor)
    plain = load_model(DAMPER)
    known = error(odd, plain.with_effect(gain, GAINS[gain]))
    of_noise = factor if gain == "force_gain" else 1.0
    assert known == pytest.approx(of_noise * error(true, plain), rel=1e-3)
    assert error(odd, plain) > 1.05 * known


def test_a_known_gain_of_the_velocity_is_undone_before_the_motion_is_fused(data):
    """The other channels outvote a velocity that is out of scale; divided by its gain it agrees with them."""
    records, name = load(data), "deflection_velocity"
    odd = records.mapped(
        lambda r: replace(r, channels={**r.channels, name: 1.1 * r.channels[name]})
    )
    plain = load_model(DAMPER)
    true = opened(records, plain).problem
    known = opened(odd, plain.with_effect("velocity_gain", {"g_v": 1.1})).problem
    unknown = opened(odd, plain).problem
    assert known.noise.v == pytest.approx(true.noise.v, rel=1e-6)
    assert known.motion.v == pytest.approx(true.motion.v, abs=1e-9)
    assert unknown.noise.v > 2.0 * true.noise.v


@pytest.mark.parametrize("gain", GAINS)
def test_a_gain_is_kept_and_not_fitted(gain, data):
    model = load_model(DAMPER).with_effect(gain, GAINS[gain])
    assert gain not in {effect for effect, _ in free_parameters(model)}
    problem = opened(load(data), model).problem
    anew = restarts(model, problem, terms(model))
    assert all(m.effects.get(gain, GAINS[gain]) == GAINS[gain] for m in anew)
    fitted = baseline(on_fused(model), problem).fit.model
    assert fitted.effects.get(gain, GAINS[gain]) == GAINS[gain]
    assert not {e.name for e in missing(model, problem)} & set(GAINS)


def test_a_car_is_taken_for_its_damper(data, tmp_path):
    """What acts in the car changes nothing of what is said of the force, and is never fitted to it."""
    model = load_model(CAR)
    for name in ("tyre_damping", "guide_friction", "accelerometer_bias", "sprung_mass_error"):
        model = model.with_effect(name)
    save_model(model, tmp_path / "car.yaml")
    assert {effect for effect, _ in free_parameters(model)} == {"passive", "guo_yield", "response"}
    assert error(data, load_model(tmp_path / "car.yaml")) == error(data, load_model(DAMPER))


def test_the_lab_says_that_gains_cannot_be_known_and_why(data, tmp_path):
    for gain in GAINS:
        added = lab("add", gain, data, "--model", DAMPER, "--out", tmp_path / "m.yaml")
        assert added.exit_code == 2
        assert f"{gain} cannot be known from these channels" in added.output
        assert "cannot be known:" in lab("effects", gain).output
    listed = " ".join(lab("effects").output.replace("│", " ").split())
    assert listed.count("cannot be known") == len(GAINS)
    result = lab("effects", "--json", tmp_path / "e.json")
    assert result.exit_code == 0
    entries = json.loads((tmp_path / "e.json").read_text())["effects"]
    assert {e["effect"] for e in entries if not e["knowable"]} == set(GAINS)


@pytest.mark.slow
def test_a_diagnosis_names_them(data, tmp_path):
    result = lab("diagnose", data, "--model", DAMPER, "--json", tmp_path / "r.json")
    assert result.exit_code == 0, result.output
    r = json.loads((tmp_path / "r.json").read_text())
    said = {e["effect"]: e["because"] for e in r["unknowable"]}
    assert said == {e.name: e.unknowable_because for e in CATALOGUE.unknowable()}
    assert not set(said) & {c["effect"] for c in r["candidates"]}
    assert (
        "cannot be known from these channels: velocity_gain, duty_gain and force_gain"
        in result.output
    )
