"""Ctrl-C in `lab improve` keeps what is done, and the same command goes on from there."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest
from er_model_lab.cli import app, missing, running
from er_model_lab.diagnosis import evidence, investigation
from er_model_lab.diagnosis.candidates import baseline, refit
from er_model_lab.diagnosis.ranking import TRYING
from er_model_lab.fitting import fit
from er_model_lab.level.damper import opened
from er_model_lab.problem.fit_store import packed, unpacked
from er_model_lab.problem.forward import DamperForward
from er_model_lab.vehicle.ride_problem import open_ride
from er_model_lab.verbs.load import load
from er_model_lab.verbs.resume import resume
from er_models.files import load_model
from typer.testing import CliRunner

from test.conftest import ROOT
from test.sample import with_friction, write_ride, write_sample

MODEL = ROOT / "config/dampers/inove_guo.yaml"
CAR = ROOT / "config/vehicles/inove_quarter_car.yaml"
BOTH = {"coulomb_friction", "preload"}


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    truth = with_friction("inove_guo").with_effect("preload", {"F_0": 1.5})
    return write_sample(tmp_path_factory.mktemp("data") / "run.csv", seed=4, truth=truth)


FEW = ("preload", "gas_spring", "coulomb_friction", "shear_thinning", "end_stop")


def improve(data, folder, stop_in_round, monkeypatch):
    """Run the command; Ctrl-C comes in that round of trying effects (0: never)."""
    rounds = []

    def told(stage, done, total, best):
        rounds.extend([1] if (stage, done) == (TRYING, 1) else [])
        if (stage, done, len(rounds)) == (TRYING, 2, stop_in_round):
            raise KeyboardInterrupt

    @contextmanager
    def progress(*_):
        yield told

    monkeypatch.setattr(missing, "progress", progress)
    words = [
        "improve",
        data,
        "--model",
        MODEL,
        "--out",
        folder / "m.yaml",
        "--json",
        folder / "r.json",
    ]
    return CliRunner().invoke(app.app, [str(w) for w in words])


@pytest.mark.slow
def test_what_was_done_is_kept_and_gone_on_from(data, tmp_path, monkeypatch):
    stopped = improve(data, tmp_path, 2, monkeypatch)
    assert stopped.exit_code == 130, stopped.output
    first = json.loads((tmp_path / "r.json").read_text())
    assert first["interrupted"] is True
    assert len(first["steps"]) == 2
    (kept,) = first["effects"]
    assert kept in BOTH
    left = load_model(tmp_path / "m.yaml")
    assert kept in left.effects
    assert not set(left.effects) >= BOTH
    assert left.history[-1]["interrupted"] is True

    model = load_model(MODEL)
    other = load(write_sample(tmp_path / "other.csv", seed=5))
    changed = model.with_effect("preload", {"F_0": 1.0})
    here = load(data)
    added = [resume(left, m, d).added for m, d in ((model, here), (model, other), (changed, here))]
    assert added == [(kept,), None, None]  # another model, or other data, begin anew

    done = improve(data, tmp_path, 0, monkeypatch)
    assert done.exit_code == 0, done.output
    r = json.loads((tmp_path / "r.json").read_text())
    assert r["interrupted"] is False
    assert [s["added"] for s in r["steps"][:2]] == [s["added"] for s in first["steps"]]
    assert set(r["effects"]) == BOTH
    assert "went on" in r["notes"][0]
    errors = [s["rmse_held_out"] for s in r["steps"]]
    assert errors[-1] < 0.5 * errors[1] < 0.5 * errors[0]
    model = load_model(tmp_path / "m.yaml")
    assert set(model.effects) >= BOTH
    assert model.history[-1]["interrupted"] is False


@pytest.mark.slow
def test_before_an_effect_is_found_the_fits_are_kept_beside(data, tmp_path, monkeypatch):
    result = improve(data, tmp_path, 1, monkeypatch)
    assert result.exit_code == 130
    assert "m.begun.yaml; the same command goes on from there" in result.output
    assert [path.name for path in tmp_path.iterdir()] == ["m.begun.yaml"]
    left = load_model(tmp_path / "m.begun.yaml")
    assert left.effects == load_model(MODEL).effects
    assert len(unpacked(left.history[-1]["fits"])) > 1

    done = improve(data, tmp_path, 0, monkeypatch)
    assert done.exit_code == 0, done.output
    r = json.loads((tmp_path / "r.json").read_text())
    assert "went on" in r["notes"][0]
    assert set(r["effects"]) == BOTH
    assert not (tmp_path / "m.begun.yaml").exists()


BEGIN = """
import time
import er_model_lab.verbs.improve as verb
from er_model_lab.cli.app import main
from er_models.parallel import threads

verb.KEEP_EVERY = 0.1
threads().submit(time.sleep, 30.0)  # a fit that takes long
main()
"""


@pytest.mark.alone
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGKILL])
def test_whatever_ends_it_what_was_done_is_kept(number, data, tmp_path):
    """Within two seconds, and it is gone on from."""
    out = tmp_path / "m.yaml"
    command = [sys.executable, "-c", BEGIN, "improve", data, "--model", MODEL, "--out", out]
    env = os.environ | {"PYTHONFAULTHANDLER": "1"}
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=env)
    while not (kept := tmp_path / "m.begun.yaml").exists():
        assert process.poll() is None
        time.sleep(0.02)
    asked = time.monotonic()
    process.send_signal(number)
    try:
        said = process.communicate(timeout=25.0)[1]
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGABRT)
        pytest.fail(process.communicate()[1])  # where it stands
    assert time.monotonic() - asked < 2.0
    if number != signal.SIGKILL:
        assert (process.returncode, said.count("\n")) == (130, 1)
        assert said.startswith("interrupted: what was done is kept in ")
    left = load_model(kept)
    assert resume(left, load_model(MODEL), load(data)).noted


@pytest.fixture(scope="module")
def stop_and_friction(tmp_path_factory):
    """Measurements with two effects that are found one after the other."""
    truth = with_friction("inove_guo").with_effect("end_stop", {"k_b": 6000.0, "x_b": 0.01})
    folder = tmp_path_factory.mktemp("stop")
    return write_sample(folder / "run.csv", seed=4, seconds=6.0, truth=truth)


@pytest.mark.slow
@pytest.mark.parametrize("most", [3, 1])
def test_an_interruption_changes_nothing_in_the_end(
    stop_and_friction, tmp_path, monkeypatch, most
):
    """It comes in the second round of one search, or where a search ends with one effect in the second pass."""
    for module in (investigation, evidence):
        monkeypatch.setattr(module, "MOST_EFFECTS", most)
    monkeypatch.setattr(
        DamperForward, "candidates", lambda _, model: tuple(model.catalogue[n] for n in FEW)
    )
    fitted, made, counts, results, models = fit._fitted, [], [], [], []
    monkeypatch.setattr(fit, "_fitted", lambda *words: made.append(1) or fitted(*words))
    for name, stops in (("at_once", (0,)), ("later", (2, 0))):
        folder = tmp_path / name
        for k in stops:
            made.clear()
            stopped = improve(stop_and_friction, folder, k, monkeypatch)
            assert stopped.exit_code == (130 if k else 0)
        counts.append(len(made))
        results.append(json.loads((folder / "r.json").read_text()))
        models.append((folder / "m.yaml").read_text())
    at_once, later = results
    assert len(at_once["effects"]) > 1
    assert later["notes"].pop(0).startswith("went on")
    assert later == at_once
    assert models[0] == models[1]
    assert counts[1] < counts[0] - len(FEW)  # what was fitted before is not fitted again


def test_a_fit_is_made_once_and_is_the_same_again(stop_and_friction):
    model, noted = load_model(MODEL), {}
    problem = replace(opened(load(stop_and_friction), model).problem, noted=noted)
    base = baseline(model, problem)
    stop = refit(base, model.catalogue["end_stop"], problem)
    made = dict(noted)
    assert len(made) > 1
    kept = replace(problem, noted=unpacked(packed(made)))
    again = refit(baseline(model, kept), model.catalogue["end_stop"], kept)
    assert kept.noted == made
    for name in ("theta", "residual", "jacobian", "at_bound"):
        np.testing.assert_array_equal(getattr(again.fit, name), getattr(stop.fit, name))
    assert (again.mse, again.fit.iterations) == (stop.mse, stop.fit.iterations)
    other = replace(kept, force=kept.force + 1e-9)
    baseline(model, other)
    assert len(kept.noted) > len(made)


@pytest.mark.parametrize("more", [{}, {"max_iter": 3}, {"max_iter": 0}, {"target": 0.0}])
def test_so_is_a_fit_to_a_car(tmp_path, more):
    data = load(write_ride(tmp_path / "ride.csv", seed=1, seconds=4.0))
    problem, base = open_ride(data, load_model(CAR))
    problem, grown = replace(problem, noted={}), base.model.with_effect("guide_friction")
    known = base.jacobian if more else None
    first, again = (fit.fit(grown, problem, known=known, **more) for _ in range(2))
    assert len(problem.noted) == 1
    assert first is not again
    for name in ("theta", "residual", "jacobian", "at_bound"):
        np.testing.assert_array_equal(getattr(again, name), getattr(first, name))


@pytest.mark.parametrize("word", ["", "None", "eJw=", "AAAA", "\u00e9", packed({})[:-4]])
def test_what_holds_no_notes_is_refused(word):
    with pytest.raises(ValueError):
        unpacked(word)


def test_an_interruption_after_the_work_says_what_is_written(data, tmp_path, monkeypatch):
    def stopped(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(running, "_write_report", stopped)
    out, told = tmp_path / "m.yaml", tmp_path / "r.json"
    words = [
        "add",
        "preload",
        data,
        "--model",
        MODEL,
        "--out",
        out,
        "--json",
        told,
        "--report",
        tmp_path / "r",
    ]
    done = CliRunner().invoke(app.app, [str(w) for w in words])
    assert done.exit_code == 130
    assert f"interrupted: {out} and {told} written, no more" in done.output
    assert "preload" in load_model(out).effects
