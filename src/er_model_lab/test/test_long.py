"""Data too long to be searched whole: what is chosen, what they remember, and the check on all of them."""

import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from er_model_lab.diagnosis.candidates import baseline
from er_model_lab.fitting.fit import fit
from er_model_lab.planning.question import ask
from er_model_lab.problem import stretches
from er_model_lab.problem.prepare import prepare
from er_model_lab.results.by_record import by_record, flagged
from er_model_lab.span.span import spanned
from er_model_lab.span.whole_record import on_whole
from er_model_lab.verbs import plan
from er_model_lab.verbs.compare import compare
from er_model_lab.verbs.identify import identify
from er_model_lab.verbs.load import load
from er_models.files import load_model, save_model
from er_models.prediction import motion, predict
from er_records.dataset import Dataset
from er_records.load import fingerprint
from er_records.record import Record
from er_records.write import write_parquet
from lab_help import DT, GUO, imposed

HEAT = {"t_h": 60.0, "b_v": 0.6, "b_y": 0.6}


def made(seconds, truth=None, seed=1, still=0.0, name="run"):
    """A record of six sines after a standstill, and the true motion."""
    rng = np.random.default_rng(seed)
    truth, n = truth or load_model(GUO), round(seconds / DT)
    x, v, a, u = imposed(rng, n)
    rest = round(still / DT)
    k = n - rest
    x, v, a = (np.concatenate([np.zeros(rest), y[:k]]) for y in (x - x[0], v, a))
    channels = {
        "deflection": x + 2e-5 * rng.standard_normal(n), "duty": u,
        "deflection_velocity": v + 1e-3 * rng.standard_normal(n),
        "sprung_acceleration": a + 0.025 * rng.standard_normal(n),
        "unsprung_acceleration": 0.025 * rng.standard_normal(n),
        "damper_force": predict(truth, motion(DT, x, v, u, a)) + 0.15 * rng.standard_normal(n),
    }  # fmt: skip
    return Record(name, np.arange(n) * DT, channels)


@pytest.fixture
def short(monkeypatch):
    """Three minutes count as long, and half a minute of them is searched."""
    monkeypatch.setattr(stretches, "LONG", 8000)
    monkeypatch.setattr(stretches, "USED", 6000)


def test_ordinary_data_are_searched_whole():
    data = Dataset.of([made(20.0)], [made(20.0, seed=2)])
    assert stretches.shortened(data) is data


def test_the_one_visit_to_a_corner_is_among_what_is_searched(short):
    record = made(200.0)
    x, u = record.channels["deflection"].copy(), np.zeros(len(record))
    rows = slice(26500, 26600)  # half a second of a duty and a deflection that occur nowhere else
    x[rows] *= 3.0
    u[rows] = 0.3
    record = Record("run", record.t, {**record.channels, "deflection": x, "duty": u})
    data = stretches.shortened(Dataset.of([record]))
    assert sum(map(len, data.records)) <= 6000
    firsts = [p.i for p in data.places]
    assert any(i <= 26500 and i + 2500 >= 26600 for i in firsts), firsts
    again = stretches.shortened(Dataset.of([record]))
    assert again.records[0].name == data.records[0].name


def test_what_heats_remembers_the_whole_record(short):
    truth = load_model(GUO).with_effect("self_heating", HEAT)
    data = stretches.shortened(Dataset.of([made(200.0, truth)]))
    alone = prepare(data)
    problem, _ = on_whole(alone, data)
    late = problem.used & (problem.extra[-1][1] > 100.0)
    here, rest = (float(np.std((p.force - p.predict(truth))[late])) for p in (problem, alone))
    assert here < 0.2
    assert rest > 2.0 * here


@pytest.mark.slow
def test_a_stretch_that_was_not_searched_and_fails_is_searched_next(short):
    model, record = load_model(GUO), made(200.0)
    places = stretches.places_of([record])
    unseen = next(p for p in places if p not in stretches.chosen([record], 6000))
    force = record.channels["damper_force"].copy()
    force[unseen.i : unseen.j] += 4.0
    record = Record("run", record.t, {**record.channels, "damper_force": force})
    data = stretches.shortened(Dataset.of([record]))
    problem, span = spanned(prepare(data), data)
    found = span.checked(problem, problem.force - problem.predict(model), given=model)
    assert found.missed == [unseen]
    said = found.as_json(again=False)
    assert said["worst"][0]["from"] == pytest.approx(unseen.i * DT)
    assert said["rmse"]["given"]["elsewhere"] > 2.0 * np.sqrt(found.held_out)
    more = stretches.with_more(data, found.missed)
    assert more.score == ()
    assert {p.i for p in more.places} == {p.i for p in data.places} | {unseen.i}


@pytest.fixture
def file(tmp_path):
    """A hundred seconds in a file."""
    write_parquet(made(100.0), tmp_path / "run.parquet")
    return tmp_path / "run.parquet"


@pytest.mark.slow
@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_identify_says_what_it_used_and_names_all_data(short, file, tmp_path):
    out = tmp_path / "new.yaml"
    result = identify(load(file), load_model(GUO), name="new")
    content = result.to_dict()
    assert content["long"]["seconds"] == pytest.approx(100.0)
    assert content["notes"][0].startswith("30 of 100 s searched")
    assert content["notes"][0] in result.notes
    save_model(result.model, out)
    found = load_model(out)
    assert found.history[-1]["records"] == ["run"]
    assert found.source.startswith("identified from 1 records")
    told = compare(load(file), found, load_model(GUO)).to_dict()
    first, second = told["models"]
    assert (first["fitted_to_these_data"], second["fitted_to_these_data"]) == (True, False)
    assert first["rmse"] == pytest.approx(told["rmse"], rel=1e-12)
    assert told["rmse"] == told["long"]["rmse"]["given"]["all"]
    assert (
        told["rmse_by_record"] == first["rmse_by_record"] == {"run": pytest.approx(told["rmse"])}
    )
    assert told["nrmse"] == pytest.approx(first["nrmse"])
    assert told["explainable"] == pytest.approx(first["explainable"])


@pytest.mark.slow
def test_plan_says_what_it_used_and_names_all_data(short, file):
    model, data = load_model(GUO), load(file)
    problem, known = plan._measured(data, ask(model, (), "preload"), model, 0, anyway=False)
    assert problem.notes[0].startswith("30 of 100 s searched")
    assert known["long"]["seconds"] == pytest.approx(100.0)
    assert known["provenance"] == {"data": fingerprint(data.records), "records": ["run"]}


@pytest.mark.slow
def test_a_plan_undoes_the_gain_that_the_model_knows():
    record, model = made(12.0), load_model(GUO)
    odd = {**record.channels, "deflection_velocity": 1.1 * record.channels["deflection_velocity"]}
    known, asked = model.with_effect("velocity_gain", {"g_v": 1.1}), ask(model, (), "preload")
    true, _ = plan._measured(Dataset.of([record]), asked, model, 0, anyway=False)
    out_of_scale = Dataset.of([Record("run", record.t, odd)])
    problem, _ = plan._measured(out_of_scale, asked, known, 0, anyway=False)
    assert problem.motion.v == pytest.approx(true.motion.v, abs=1e-9)


def test_stretches_searched_before_stay_when_more_join_them(short):
    record = made(200.0)
    data = stretches.shortened(Dataset.of([record]))
    seen = {p.i for p in data.places}
    fresh = [p for p in stretches.places_of([record]) if p.i not in seen]
    more = stretches.with_more(data, fresh[:1])
    last = stretches.with_more(more, fresh[1:2])
    assert {p.i for p in last.places} == seen | {fresh[0].i, fresh[1].i}


def test_standstill_at_the_beginning_does_not_spoil_the_motion():
    model, record = load_model(GUO), made(40.0, still=20.0)
    problem = prepare(Dataset.of([record]))
    moving = problem.used & (problem.motion.t > 21.0)
    assert np.std((problem.force - problem.predict(model))[moving]) < 0.2


@pytest.mark.slow
def test_a_record_left_out_is_predicted_from_the_others():
    model = load_model(GUO)
    odd = model.with_effect("preload", {"F_0": 2.0})
    records = [
        made(20.0, name="a"),
        made(20.0, seed=2, name="b"),
        made(20.0, odd, seed=3, name="odd"),
    ]
    data = Dataset.of(records)
    problem = prepare(data)
    base = baseline(model.with_effect("preload", {"F_0": 0.1}), problem)

    found = SimpleNamespace(best=base, base=base, interrupted=False)
    whole, told = found, by_record(found, problem, data)
    found = {e["record"]: e for e in told}
    assert set(found) == {"a", "b", "odd"}
    rest = np.repeat([True, True, False], 4000) & problem.used
    alone = fit(base.fit.model, problem_of_rows(problem, rest))
    last = problem.used & ~np.repeat([True, True, False], 4000)
    truly = np.sqrt(np.mean(alone.residual[last] ** 2))
    assert found["odd"]["rmse_left_out"] == pytest.approx(truly, rel=0.02)
    assert found["odd"]["rmse_left_out"] > 1.2 * found["odd"]["rmse_after"]
    first = Dataset.of(records[:1])
    assert by_record(whole, prepare(first), first) == []


def test_after_an_interruption_records_are_left_out_in_a_straight_line_alone(monkeypatch):
    """It takes a moment, where predictions without each record take seconds."""
    model = load_model(GUO).with_effect("preload", {"F_0": 0.1})
    data = Dataset.of([made(8.0, seed=k, name=name) for k, name in enumerate("abc")])
    problem, asked = prepare(data), []
    base = baseline(model, problem)

    def cross_validated(fitted, problem, *, straight):
        asked.append(straight)
        return fitted.residual, None

    monkeypatch.setattr("er_model_lab.results.by_record.cross_validated", cross_validated)
    for interrupted in (False, True):
        by_record(SimpleNamespace(best=base, base=base, interrupted=interrupted), problem, data)
    found = SimpleNamespace(best=base, base=base, interrupted=False)
    by_record(found, problem, data, straight=True)
    assert asked == [False, True, True]


@pytest.mark.parametrize(
    ("after", "than"), [(0.9, []), (1.04, []), (1.1, ["before"]), (3.0, ["nothing", "before"])]
)
def test_a_record_that_is_described_worse_is_flagged(after, than):
    known = {"record": "a", "rms_force": 2.0, "rmse_before": 1.0, "rmse_after": after}
    (told,), notes = flagged([known])
    assert told["worse_than"] == than
    assert len(notes) == bool(than)
    assert all("record a" in note and f"{after:.3g} N" in note for note in notes)


def problem_of_rows(problem, rows):
    """The problem with these rows to learn from and none held out."""
    from dataclasses import replace

    return replace(problem, fold=np.where(rows, 0, -1), held_out=np.zeros_like(rows))


@pytest.mark.slow
@pytest.mark.alone
def test_an_hour_takes_less_than_two_gigabytes(tmp_path):
    truth = load_model(GUO).with_effect("coulomb_friction", {"F_c": 1.0, "v_0": 0.003})
    write_parquet(made(3600.0, truth, still=20.0), tmp_path / "hour.parquet")
    code = (
        "import sys; from er_model_lab.cli.app import app; app(sys.argv[1:], standalone_mode=False); "
        "print('peak', open('/proc/self/status').read().split('VmHWM:')[1].split()[0])"
    )
    words = [
        "add",
        "coulomb_friction",
        "hour.parquet",
        "--model",
        str(GUO),
        "--out",
        "m.yaml",
        "--json",
        "r.json",
    ]
    done = subprocess.run(
        [sys.executable, "-c", code, *words],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=280,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert (
        int(done.stdout.split("peak")[1]) < 2_000_000
    )  # kB, of this process: ru_maxrss begins at its parent's
    r = json.loads(Path(tmp_path / "r.json").read_text())
    assert r["long"]["seconds"] == pytest.approx(3600.0)
    assert r["long"]["searched_seconds"] < 200.0
    assert r["long"]["rmse"]["after"]["elsewhere"] < 1.1 * r["rmse_after"]["held_out"]
    assert r["long"]["rmse"]["before"]["all"] > 2.0 * r["long"]["rmse"]["after"]["all"]
