"""Records given twice are used once, and what only scores is never learnt from."""

import shutil

import numpy as np
import pytest
from er_model_lab.cli.app import app
from er_model_lab.verbs.asking import question
from er_model_lab.verbs.compare import compare
from er_model_lab.verbs.load import load
from er_models.errors import InputError
from er_models.files import load_model
from er_records.copies import used_once
from er_records.record import Record
from er_records.write import write_csv, write_parquet
from lab_help import DT, GUO, imposed
from typer.testing import CliRunner

from er_records import copies


def record(seed, name="run", n=1200):
    """A run of the same program with other noise for every seed."""
    x, v, _, u = imposed(np.random.default_rng(0), n)
    force = 60.0 * v + 20.0 * u * np.sign(v) + np.random.default_rng(seed).normal(0.0, 0.15, n)
    return Record(
        name, np.arange(n) * DT, {"deflection": x, "deflection_velocity": v, "duty": u, "damper_force": force}
    )  # fmt: skip


def table(run, path, form="%.18e", start=0.0, leave=()):
    """A run as text of few digits, with another beginning of time or fewer channels."""
    columns = {"t": run.t + start} | {n: y for n, y in run.channels.items() if n not in leave}
    rows = np.stack(list(columns.values()), axis=1)
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="", fmt=form)
    return path


@pytest.fixture
def folder(tmp_path):
    """Two runs of one program in a folder."""
    folder = tmp_path / "runs"
    for k in (1, 2):
        write_csv(record(k, f"run{k}"), folder / f"run{k}.csv")
    return folder


def test_two_runs_of_one_program_are_both_used(folder):
    assert [r.notes for r in load(folder).records] == [(), ()]


def again(folder, kind):
    """A copy of the first run in some form; where it lies."""
    first, run = folder / "run1.csv", record(1)
    path = folder / f"twin.{'parquet' if kind == 'parquet' else 'csv'}"
    if kind == "copy":
        shutil.copy(first, path)
    elif kind == "parquet":
        write_parquet(run, path)
    else:
        table(run, path, **OTHERWISE[kind])
    return path


OTHERWISE = {
    "seven digits": {"form": "%.7g"},
    "another clock": {"start": 1000.0},
    "fewer channels": {"leave": ("deflection_velocity",)},
}


@pytest.mark.parametrize("kind", ["copy", "parquet", *OTHERWISE])
def test_a_run_given_twice_is_used_once_and_both_files_are_named(kind, folder):
    twin = again(folder, kind)
    found = load(folder).records
    assert [r.file for r in found] == [str(folder / f"run{k}.csv") for k in (1, 2)]
    (note,) = found[0].notes
    assert str(twin) in note
    assert f"of {folder / 'run1.csv'}: used once" in note
    assert found[0].complete
    assert found[1].notes == ()


def test_a_path_given_twice_is_used_once(folder):
    assert [r.name for r in load(folder, folder / "run2.csv").records] == ["run1", "run2"]


@pytest.mark.parametrize("kind", ["same file", "copy", "parquet", "seven digits"])
def test_what_only_scores_must_not_be_learnt_from(kind, folder, tmp_path):
    (tmp_path / "more").mkdir()
    file = folder / "run2.csv" if kind == "same file" else again(folder, kind)
    if kind != "same file":
        file = shutil.move(file, tmp_path / "more" / file.name)
    with pytest.raises(InputError, match="held_out: expected samples that are not learnt") as told:
        compare(load(folder), load_model(GUO), held_out=load(file))
    words = ["compare", folder, "--model", GUO, "--hold-out", file]
    done = CliRunner().invoke(app, [str(w) for w in words])
    assert done.exit_code == 2
    assert "--hold-out: expected samples that are not learnt from" in done.output
    first = "run2.csv" if kind == "same file" else "run1.csv"
    for said in (str(told.value), done.output):
        assert str(file) in said
        assert str(folder / first) in said


def test_hundreds_of_runs_are_not_compared_each_with_each(monkeypatch):
    compared = []
    same = copies._same
    monkeypatch.setattr(copies, "_same", lambda a, b: compared.append(1) or same(a, b))
    runs = [record(seed, n=400) for seed in range(300)]
    assert len(used_once([*runs, *runs])) == 300
    assert len(compared) < 3000


def test_a_channel_that_is_not_known_throughout_tells_nothing_of_copies():
    t = DT * np.arange(400)
    gap = np.where(t < 0.1, np.nan, np.sin(t))
    one = Record("one", t, {"damper_force": gap, "deflection": np.sin(t)})
    other = Record("other", t, {"damper_force": gap})
    assert len(used_once([one, other, other])) == 3


def test_records_of_one_name_are_told_apart_wherever_they_come_from(tmp_path):
    files = [tmp_path / place / "run.csv" for place in "ab"]
    for k, file in enumerate(files):
        file.parent.mkdir()
        write_csv(record(k), file)
    asked = question(load(files[0]), load_model(GUO), held_out=load(files[1]))
    assert [r.name for r in asked.data.learn] == ["a/run"]
    assert [r.name for r in asked.data.score] == ["b/run"]
    both = question(load(*files), load_model(GUO)).data
    assert [r.name for r in both.learn] == ["a/run", "b/run"]
