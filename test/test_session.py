"""A session of the lab without a page: steps and undo, what is seen, what is taken away and opened again."""

from __future__ import annotations

import json
import runpy
import threading
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from er_model_lab.session import dropped
from er_model_lab.session.desk import Desk
from er_model_lab.session.job import Jobs
from er_model_lab.session.kept import packed, unpacked
from er_model_lab.session.script import alone, script
from er_model_lab.session.sight import (
    Selection,
    curve,
    look,
    loops,
    spectrum,
    tile_at,
    tile_map,
    worst,
)
from er_model_lab.session.slider import POSITIONS, Slider
from er_model_lab.session.steps import Session, Source, State, Step, Stretch, pieces

import er_model_lab as lab
from test.sample import write_sample


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Measurements of a damper with friction that the model does not hold."""
    return write_sample(tmp_path_factory.mktemp("data") / "run.csv", seed=1, seconds=9.0)


def desk_of(run: Path, folder: Path) -> Desk:
    desk = Desk(folder, given=[run])
    desk.bring([Source(run)], lab.load_model("inove_guo"), "inove_guo")
    desk.jobs.wait(60.0)
    assert desk.jobs.job is not None
    assert desk.jobs.job.error == ""
    return desk


@pytest.fixture(scope="module")
def first(run: Path) -> Desk:
    """A desk with the measurements opened, of which each test gets a copy."""
    return desk_of(run, run.parent)


@pytest.fixture
def desk(run: Path, first: Desk, tmp_path: Path) -> Desk:
    made = Desk(tmp_path / "dropped", given=[run])
    made.folder.mkdir()
    made.session, made.records = first.session, first.records
    made.sight, made.predicted = first.sight, first.predicted
    return made


def test_a_parameter_moves_the_prediction_and_is_taken_back(desk: Desk) -> None:
    first, start = desk.errors(), desk.now.known.value("passive", "c0")
    for value in (70.0, 75.0, 80.0):
        desk.take(desk.now.set("passive", "c0", value))
    assert desk.errors() != first
    assert len(desk.session.past) == 4, "a slider that is dragged is one step"
    desk.undo()
    assert desk.now.known.value("passive", "c0") == start
    assert desk.errors() == first
    desk.redo()
    assert desk.now.known.value("passive", "c0") == 80.0
    desk.take(desk.now.as_fitted())
    assert desk.errors() == first
    desk.undo()
    assert desk.now.known.value("passive", "c0") == 80.0
    with pytest.raises(lab.InputError, match=r"passive\.c0: expected a number from"):
        desk.now.set("passive", "c0", -1.0)


def test_an_effect_is_switched_off_and_on_again_with_its_values(desk: Desk) -> None:
    given, first = desk.now.known, desk.errors()
    desk.take(desk.now.switched("response", on=False))
    assert "response" not in desk.now.known.effects
    assert desk.errors() != first
    desk.take(desk.now.switched("response", on=True))
    assert desk.now.known.digest() == given.digest()
    assert desk.errors() == first
    with pytest.raises(lab.InputError, match="expected an effect that was switched off"):
        desk.now.switched("coulomb_friction", on=True)


def test_the_program_of_a_session_makes_the_same_model(
    desk: Desk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk.hold([Stretch(0, 4.0, 6.0)])
    desk.jobs.wait()
    desk.take(desk.now.set("passive", "c0", 70.0))
    desk.add("coulomb_friction")
    with pytest.raises(lab.InputError, match="nothing is changed while a job runs"):
        desk.take(desk.now.set("passive", "c0", 71.0))
    desk.jobs.wait()
    desk.take(desk.now.switched("response", on=False))
    desk.take(desk.now.switched("response", on=True))
    fall = [stage.errors.held_out or 0.0 for stage in desk.fall()]
    assert fall[1] < 0.3 * fall[0], "from the model as given to the friction that was hidden"
    off = desk.errors(desk.now.known.without_effect("coulomb_friction"))
    desk.take_back("coulomb_friction")
    desk.jobs.wait()
    back = desk.fall()[-1].errors
    assert off is not None
    assert "coulomb_friction" not in desk.now.known.effects
    assert back == desk.errors()
    assert back.train < 0.95 * off.train, "what stays is refitted"
    program = tmp_path / "session.py"
    program.write_text(script(desk.session), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    made = runpy.run_path(str(program), run_name="__main__")
    assert made["model"].digest() == desk.now.known.digest()
    assert lab.load_model("model.yaml").digest() == desk.now.known.digest()
    assert made["data"].score[0].t[0] == pytest.approx(4.0, abs=0.01)
    kept = tmp_path / "kept.zip"
    kept.write_bytes(packed(desk.session, desk.folder))
    again = unpacked(kept, desk.folder, desk.given)
    assert [s.model and s.model.digest() for s in again.past] == [
        s.model and s.model.digest() for s in desk.session.past
    ]
    assert script(again) == script(desk.session)
    with pytest.raises(lab.InputError, match="named on the command line"):
        unpacked(kept, desk.folder)


def test_a_new_model_is_scaled_to_the_data_and_the_program_makes_it_again(
    desk: Desk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk.new("er")
    desk.jobs.wait()
    assert desk.jobs.job is not None
    assert (desk.jobs.job.error, desk.now.step.says) == ("", "new model start er")
    assert desk.now.known.digest() == lab.new(desk.data, "er").digest()
    program = tmp_path / "session.py"
    program.write_text(script(desk.session), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    made = runpy.run_path(str(program), run_name="__main__")
    assert made["model"].digest() == desk.now.known.digest()
    desk.undo()
    assert desk.now.known.name == "inove_guo"


def test_dropped_data_travel_with_the_session(run: Path, tmp_path: Path) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    first.mkdir()
    second.mkdir()
    path = dropped.place_for(first, "../../run.csv")
    path.write_bytes(run.read_bytes())
    kept = tmp_path / "kept.zip"
    kept.write_bytes(packed(desk_of(path, first).session, first))
    session = unpacked(kept, second)
    assert session.now.sources == (Source(second / "run.csv"),)
    assert (second / "run.csv").read_bytes() == run.read_bytes()
    assert "lab.load('data/run.csv')" in zipfile.ZipFile(kept).read("session.py").decode()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            lambda c: c["steps"][1].update(sources=[["/etc/passwd", None]]),
            "named on the command line",
        ),
        (
            lambda c: c["steps"][1].update(sources=[["../up.csv", None]]),
            "named on the command line",
        ),
        (lambda c: c["steps"][0].update(sources=[["evil.py", None]]), "no program"),
        (lambda c: c.update(schema="other"), "er_lab_session/1"),
        (lambda c: c["steps"][0].pop("held"), "a session that was taken from this page"),
    ],
)
def test_a_session_reaches_for_nothing_else(tmp_path: Path, change, said: str) -> None:
    state = {
        "step": ["open", "", {}],
        "sources": [],
        "held": [],
        "model": None,
        "fitted": None,
        "off": {},
    }
    content = {"schema": "er_lab_session/1", "seed": 0, "steps": [dict(state), dict(state)]}
    change(content)
    with zipfile.ZipFile(tmp_path / "s.zip", "w") as whole:
        whole.writestr("session.json", json.dumps(content))
        whole.writestr("evil.py", "raise SystemExit")
    (tmp_path / "in").mkdir()
    with pytest.raises(lab.InputError, match=said):
        unpacked(tmp_path / "s.zip", tmp_path / "in")
    assert [*(tmp_path / "in").iterdir()] == []


def test_no_session_and_no_bomb(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "s.zip").write_bytes(b"PK\x03\x04nothing")
    with pytest.raises(lab.InputError, match="a session that was taken"):
        unpacked(tmp_path / "s.zip", tmp_path)
    with zipfile.ZipFile(tmp_path / "b.zip", "w", zipfile.ZIP_DEFLATED) as whole:
        whole.writestr("session.json", b" " * 5000)
    monkeypatch.setattr("er_model_lab.session.kept.LARGEST", 4000)
    with pytest.raises(lab.InputError, match="at most"):
        unpacked(tmp_path / "b.zip", tmp_path)


@pytest.mark.parametrize(
    ("name", "kept"),
    [
        ("../../etc/passwd.csv", "passwd.csv"), ("C:\\x\\run.csv", "run.csv"), ("a\0b;rm -rf.csv", "a_b_rm -rf.csv"),
        ("..", "file"), (".hidden.csv", "hidden.csv"), ("", "file"), (f"{'x' * 300}.csv", f"{'x' * 100}.csv"),
    ],
)  # fmt: skip
def test_a_dropped_file_gets_a_name_within_its_folder(
    tmp_path: Path, name: str, kept: str
) -> None:
    place = dropped.place_for(tmp_path, name)
    assert place == tmp_path / kept
    place.touch()
    assert dropped.place_for(tmp_path, name).parent == tmp_path
    assert not dropped.place_for(tmp_path, name).exists()


def test_programs_and_other_kinds_are_refused(tmp_path: Path) -> None:
    assert dropped.kind_of("own.py", code=True) == "code"
    assert dropped.kind_of("RUN.CSV", code=False) == "data"
    with pytest.raises(lab.InputError, match="--allow-code"):
        dropped.kind_of("own.py", code=False)
    with pytest.raises(lab.InputError, match="suffix"):
        dropped.kind_of("run.exe", code=True)
    (tmp_path / "car.yaml").write_text("damper: ../../../etc/passwd\n", encoding="utf-8")
    with pytest.raises(lab.InputError, match="damper: expected a damper"):
        dropped.model_of(tmp_path / "car.yaml")
    (tmp_path / "big.yaml").write_bytes(b"#" * (dropped.LARGEST_MODEL + 1))
    with pytest.raises(lab.InputError, match="at most 1 MB"):
        dropped.model_of(tmp_path / "big.yaml")


def test_what_lies_beside_a_bag_is_no_model_and_a_zip_of_measurements_is_unpacked(
    run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(lab.InputError, match="the bag itself"):
        dropped.kind_of("metadata.yaml", code=False)
    packed_bag, bare, laid = tmp_path / "bag.zip", tmp_path / "bare.zip", tmp_path / "in"
    laid.mkdir()
    with zipfile.ZipFile(packed_bag, "w") as whole:
        whole.writestr("bag/metadata.yaml", "rosbag2_bagfile_information: {}")
        whole.write(run, "../../bag/bag_0.csv")
    assert dropped.kind_of("bag.zip", code=False) == "zip"
    assert not dropped.is_session(packed_bag)
    assert dropped.measurements_of(packed_bag, laid) == [laid / "bag_0.csv"]
    assert (laid / "bag_0.csv").read_bytes() == run.read_bytes()
    with zipfile.ZipFile(bare, "w") as whole:
        whole.writestr("notes.md", "")
    with pytest.raises(lab.InputError, match="0 measurements"):
        dropped.measurements_of(bare, laid)
    monkeypatch.setattr(dropped, "LARGEST", 1000)
    with pytest.raises(lab.InputError, match="unpacked"):
        dropped.measurements_of(packed_bag, laid)


def test_what_is_dropped_has_bounds_alone_and_together(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk = Desk(tmp_path)
    monkeypatch.setattr("er_model_lab.session.desk.BIGGEST", 5_000_000)
    monkeypatch.setattr(dropped, "LARGEST", 3_000_000)
    assert desk.admitted("run.csv", 3_000_000) == "data"
    with pytest.raises(lab.InputError, match=r"at most 3 MB more, found 3\.1 MB"):
        desk.admitted("run.csv", 3_100_000)
    (tmp_path / "inner").mkdir()
    for name in ("first.csv", "inner/second.csv"):
        (tmp_path / name).write_bytes(b"x" * 2_000_000)
    assert desk.room() == 1_000_000
    assert desk.admitted("run.csv", 1_000_000) == "data"
    with pytest.raises(lab.InputError, match="at most 1 MB more"):
        desk.admitted("run.csv", 1_100_000)


def test_what_is_seen_agrees_with_the_residual(desk: Desk) -> None:
    sight, left = desk.sight, desk.residual
    assert sight is not None
    assert left is not None
    z = tile_map(sight, left, None, 1)
    inside = sight.problem.used & (sight.tiles.at >= 0)
    counts = np.bincount(sight.tiles.at[inside], minlength=z.size).reshape(z.shape)
    assert np.nansum(z**2 * counts) == pytest.approx(np.sum(left[inside] ** 2))
    t, y = curve(sight, left, most=300)
    assert t.size <= 302
    assert np.nanmax(y) == left.max(), "the peak stays, however few points"
    near, _ = curve(sight, left, (3.0, 4.0))
    assert near.size == pytest.approx(201, abs=3), "every sample of what is in view"
    m, at = sight.problem.motion, tile_at(sight, 0.0, 0.0)
    mask = at.mask(sight)
    assert mask.any()
    assert (np.abs(m.v[mask]) < 0.02).all()
    v, (f,) = loops(sight, [sight.force], Selection(seconds=(3.0, 4.0)).mask(sight))
    assert v.size == f.size == pytest.approx(201, abs=2)
    hz, density = spectrum(sight, np.sin(2 * np.pi * 20.0 * sight.t), np.ones(left.size, bool))
    assert hz[np.argmax(density)] == pytest.approx(20.0, abs=0.5)
    shock = np.where((sight.t > 5.0) & (sight.t < 5.2), 9.0, 0.01)
    first = worst(sight, shock)[0]
    assert first.share > 0.5
    assert first.selection.seconds is None or 4.5 < first.selection.seconds[0] < 5.5


def test_stretches_divide_records(run: Path) -> None:
    records = lab.load(run).records
    assert pieces(records, ()) == ([(0,)], [])
    learn, score = pieces(records, [Stretch(0, 4.0, 6.0)])
    assert (learn, score) == ([(0, 0, 800), (0, 1201, 1800)], [(0, 800, 1201)])
    assert pieces(records, [Stretch(0, 0.5, 6.0)])[0] == [(0, 1201, 1800)], (
        "half a second is too short to learn from"
    )
    with pytest.raises(lab.InputError, match="left to learn from"):
        pieces(records, [Stretch(0)])


def test_one_job_at_a_time_that_can_be_cancelled() -> None:
    told = list[int]()
    jobs = Jobs(lambda: told.append(1))
    begun = threading.Event()

    def work(progress, cancel) -> None:
        progress("first", 1, 3, ())
        begun.set()
        assert cancel.wait(10.0)
        raise lab.Cancelled

    jobs.start("long", work)
    assert begun.wait(10.0)
    assert jobs.job is not None
    assert (jobs.job.stage, jobs.job.done, jobs.job.total) == ("first", 1, 3)
    with pytest.raises(lab.InputError, match="one job at a time"):
        jobs.start("other", work)
    jobs.cancel()
    jobs.wait(10.0)
    assert not jobs.running
    assert "cancelled" in jobs.job.error
    jobs.start("broken", lambda *_: 1 / 0)
    jobs.wait(10.0)
    assert "ZeroDivisionError" in jobs.job.error
    assert told


def test_a_job_that_goes_on_draws_no_plot_anew(desk: Desk) -> None:
    go_on, goes_on = threading.Event(), threading.Event()

    def work(progress, cancel) -> None:
        for k in range(3):
            progress("stage", k, 3, ())
        goes_on.set()
        assert go_on.wait(10.0)

    seen, told = desk.revision, desk.progress
    desk.jobs.start("long", work)
    assert goes_on.wait(10.0)
    assert (desk.revision, desk.progress > told + 2) == (seen, True)
    go_on.set()
    desk.jobs.wait(10.0)
    assert desk.revision == seen + 1


@pytest.mark.parametrize(
    ("low", "high"), [(0.0, 2500.0), (-40.0, 40.0), (-1.0, 9.0), (1e-4, 0.1), (2.0, 3.0)]
)
def test_a_slider_is_fine_within_bounds(low: float, high: float) -> None:
    slider = Slider(low, high)
    assert slider.value(0) == low
    assert slider.value(POSITIONS) == high
    for value in (low, 0.97 * low + 0.03 * high, 0.5 * (low + high), high):
        at = slider.position(value)
        assert slider.value(at) == pytest.approx(value, abs=1e-5 * (high - low))
        assert abs(slider.value(at + 1) - value) <= 2e-3 * (high - low) or at >= POSITIONS
    small = 0.03 * (high - low) + low if low >= 0.0 else 0.03 * high
    step = slider.value(slider.position(small) + 1) - small
    assert 0.0 < step < 0.012 * max(abs(small), 0.03 * high), (
        "one position moves a small value by about a hundredth"
    )


def test_what_is_shown_is_of_the_data_of_the_step(desk: Desk) -> None:
    first = desk.errors()
    desk.go(desk.session.at(0))
    desk.jobs.wait()
    assert (desk.sight, desk.records, desk.errors()) == (None, (), None)
    with pytest.raises(lab.InputError, match="drop a file"):
        desk.learn()
    desk.redo()
    desk.jobs.wait()
    assert len(desk.records) == 1
    assert desk.errors() is None, "no model yet"
    desk.redo()
    desk.jobs.wait()
    assert desk.errors() == first


def test_undo_has_an_end() -> None:
    session = Session()
    assert session.undone() is session
    assert session.redone() is session


def test_a_planned_run_and_another_model_beside(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = {}
    monkeypatch.setattr(
        "er_model_lab.verbs.plan.plan", lambda model, **how: asked.update(how) or "planned"
    )
    desk.plan(between=("coulomb_friction", "stribeck_friction"))
    desk.jobs.wait()
    assert desk.planned == "planned"
    assert asked["between"] == ("coulomb_friction", "stribeck_friction")
    assert desk.laid is None
    first, given = desk.predicted, desk.errors()
    desk.take(desk.now.set("passive", "c0", 70.0))
    desk.lay(next(name for name in desk.choice if name.endswith("model inove guo")))
    assert desk.laid is not None
    assert np.array_equal(desk.laid, first)
    assert desk.errors(desk.choice[desk.beside]) == given
    with pytest.raises(lab.InputError, match="shipped"):
        desk.lay("nobody")
    desk.lay("inove_bingham")
    assert not np.array_equal(desk.laid, first)
    desk.lay(None)
    assert desk.laid is None


def test_a_stretch_is_held_out_where_it_lies_and_another_one_after_it(desk: Desk) -> None:
    desk.hold_between(3.0, 4.5)
    desk.jobs.wait()
    assert desk.sight is not None
    sight = desk.sight
    assert sight.ends == pytest.approx((0.0, 8.995))
    held = np.sort(sight.t[sight.problem.held_out])
    assert 3.0 <= held[0] < 3.5, "what runs in does not score"
    assert held[-1] == pytest.approx(4.5, abs=0.02)
    t, y = curve(sight, sight.force, (2.9, 3.1))
    assert np.isfinite(y).sum() == pytest.approx(41, abs=3)
    assert np.nanmax(np.diff(t)) < 0.01, "the pieces lie side by side"
    desk.hold_between(4.0, 6.0)
    with pytest.raises(lab.InputError, match="while a job runs"):
        desk.hold_between(7.5, 99.0)
    desk.jobs.wait()
    desk.hold_between(7.5, 99.0)
    desk.jobs.wait()
    assert desk.now.held == (
        Stretch(0, 3.0, pytest.approx(6.0)),
        Stretch(0, pytest.approx(7.5), pytest.approx(8.995)),
    )
    with pytest.raises(lab.InputError, match="at least 1 s of a record"):
        desk.hold_between(1.0, 1.5)


def test_what_is_wrong_is_shown_where_it_is(run: Path, tmp_path: Path) -> None:
    first = lab.load(run).records[0]
    y = first.channels["damper_force"].copy()
    y[1000:1080] = 0.66 * y.max()
    spoilt = replace(first, name="spoilt", channels={**first.channels, "damper_force": y})
    sight = look(
        lab.Dataset.of([first, spoilt]), lab.load_model("inove_guo"), whole=[first, spoilt]
    )
    (found,) = [f for f in sight.preflight.findings if f.check == "held" and f.spans]
    begin = sight.parts[1].begin
    assert sight.places(found) == [pytest.approx((begin + 5.0, begin + 5.395))]
    cut = lab.Dataset.of([first, spoilt.slice(0, 1040)], [spoilt.slice(1040, 1800)])
    again = look(cut, lab.load_model("inove_guo"), whole=[first, spoilt])
    places = [s for f in again.preflight.findings if f.check == "held" for s in again.places(f)]
    assert places
    assert all(begin + 4.99 <= a <= b <= begin + 5.4 for a, b in places)


OWN = '''"""A pull that follows the duty."""
from er_models.effect import Effect, Param, Signature


def sense(K: float, f_m: float, u: float) -> float:
    """Reported force [N]: K per duty more."""
    return f_m + K * u


EFFECT = Effect(
    "duty_pull", "sensing", "Pull of the duty", "The wires couple into the load cell, which shows the duty.",
    (Param("K", "N/duty", -2.0, 2.0, 0.0, (0.05, -0.05), "force shown per duty"),), {"sense": sense},
    Signature("a force that follows the duty", "force-duty", "steps of the duty at standstill", ("preload",)),
    "own measurement",
)
'''


def test_own_effects_and_dropped_files_go_with_the_program_and_the_session(
    run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, away, second = (tmp_path / name for name in ("page", "away", "second"))
    for each in (folder, away, second):
        each.mkdir()
    data, own = folder / "run.csv", folder / "own.py"
    data.write_bytes(run.read_bytes())
    own.write_text(OWN, encoding="utf-8")
    begun = State().started(lab.load_model("inove_guo", [own]), "inove_guo", [own])
    model = begun.known.with_effect("duty_pull", {"K": 0.5})
    last = replace(begun, model=model, step=Step("on", "duty_pull", {"K": 0.5}))
    session = Session((State(), begun, last))

    program = alone(session.then(last.with_data([Source(data)])), folder)
    assert str(folder) not in program
    said = program.split('"""')[1]
    assert [line.strip() for line in said.splitlines()[3:5]] == ["run.csv", "own.py"]
    own.rename(away / "own.py")
    (away / "session.py").write_text(alone(session, folder), encoding="utf-8")
    monkeypatch.chdir(away)
    made = runpy.run_path("session.py", run_name="__main__")
    assert made["model"].digest() == model.digest()

    (away / "own.py").rename(own)
    kept = tmp_path / "kept.zip"
    kept.write_bytes(packed(session, folder))
    again = unpacked(kept, second, code=True)
    assert again.code == (second / "own.py",)
    assert again.now.known.digest() == model.digest()
    with pytest.raises(lab.InputError, match="--allow-code"):
        unpacked(kept, tmp_path / "third")
