"""A fleet without a cluster: where recordings are found, how jobs are handed out, what is kept, what rows become."""

from __future__ import annotations

import json
import sqlite3
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

pytest.importorskip("fsspec")
pytest.importorskip("pyarrow")
from er_model_lab.fleets import engine as engines
from er_model_lab.fleets.asked import Asked, code
from er_model_lab.fleets.engine import Engine, Failure, Lost, OtherCode, spread
from er_model_lab.fleets.recording import RecordingJob, recording
from er_model_lab.fleets.run import Run, _overlaps
from er_model_lab.fleets.source import Source, sources
from er_model_lab.fleets.store import Store
from er_model_lab.fleets.unit import MOST_SAMPLES, chosen
from er_model_lab.output.report.sections.fleet import parameters
from er_model_lab.work import HERE
from er_models.files import load_model
from er_models.prediction import motion, predict
from lab_help import DT, FORCE_NOISE, GUO, imposed

import er_model_lab as lab

ASKED = Asked(load_model(GUO))


def record(
    path: Path,
    seed: int,
    friction: float = 0.0,
    seconds: float = 5.0,
    c0: float = 1.0,
    duty: float = 1.0,
) -> Path:
    """A recording of the Guo damper, with friction [N] and its damping scaled."""
    rng, model, n = np.random.default_rng(seed), load_model(GUO), round(seconds / DT)
    x, v, a, u = imposed(rng, n)
    u = duty * u
    passive = {**model.effects["passive"], "c0": c0 * model.effects["passive"]["c0"]}
    model = model.with_effect("passive", passive)
    if friction:
        model = model.with_effect("coulomb_friction", {"F_c": friction, "v_0": 0.003})
    columns = {
        "t": np.arange(n) * DT, "deflection": x + 2e-5 * rng.standard_normal(n),
        "deflection_velocity": v + 1e-3 * rng.standard_normal(n), "duty": u,
        "damper_force": predict(model, motion(DT, x, v, u, a)) + FORCE_NOISE * rng.standard_normal(n),
    }  # fmt: skip
    path.parent.mkdir(parents=True, exist_ok=True)
    pq.write_table(pa.table(columns), path)
    return path


def inside(*data: str, by: str | None = None) -> list[tuple[str, str]]:
    """Names and units of the recordings found."""
    return [(Path(s.path).name, s.unit) for s in sources(data, by)]


def test_folders_globs_and_files_name_their_units(tmp_path: Path) -> None:
    for name in ("a/1.csv", "a/2.csv", "b/3.csv"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("t,deflection\n")
    found = [("1.csv", "a"), ("2.csv", "a"), ("3.csv", "b")]
    assert inside(str(tmp_path)) == found == inside(str(tmp_path / "*" / "*.csv"))
    assert inside(str(tmp_path / "a"), by="file") == [("1.csv", "1"), ("2.csv", "2")]
    assert inside(str(tmp_path / "a"), by="namespace") == [("1.csv", ""), ("2.csv", "")]
    with pytest.raises(lab.InputError, match="nothing there"):
        inside(str(tmp_path / "c"))
    with pytest.raises(lab.InputError, match="at least one recording"):
        inside(str(tmp_path / "*.csv"))
    with pytest.raises(lab.InputError, match="by: expected folder, file, namespace"):
        inside(str(tmp_path), by="serial")


def test_a_table_says_which_unit_when_and_how_far(tmp_path: Path) -> None:
    table = tmp_path / "fleet.csv"
    table.write_text(
        "path,serial,mileage [km],time,driver\nr/1.csv,007,1.5,2026-01-02T00:00:00Z,Eve\nr/2.csv,8,,1767312000.5,\n"
    )
    first, second = sources([str(table)], "serial")
    assert first == Source(
        f"{tmp_path}/r/1.csv", "007", 1767312000.0, 1500.0, (("driver", "Eve"),)
    )
    assert (second.unit, second.time, second.mileage) == ("8", 1767312000.5, None)
    with pytest.raises(lab.InputError, match="by: expected one of path, serial"):
        list(sources([str(table)]))
    for cell, said in (("far", "a number, found 'far'"), ("1e400", None)):
        table.write_text(f"path,unit,mileage\nr/1.csv,a,{cell}\n")
        if said is None:
            assert next(sources([str(table)])).mileage is None
        else:
            with pytest.raises(lab.InputError, match=said):
                list(sources([str(table)]))
    table.write_text("path,unit,mileage [furlongs]\nr/1.csv,a,1\n")
    with pytest.raises(lab.InputError, match="a unit: m, cm"):
        list(sources([str(table)]))


def test_a_url_is_found_and_fetched(tmp_path: Path) -> None:
    import fsspec
    from er_model_lab.fleets.places import content, local, token

    files = fsspec.filesystem("memory")
    files.pipe("/er_fleet/u1/a.csv", b"t,deflection\n0,1\n")
    assert list(sources(["memory://er_fleet"])) == [Source("memory:///er_fleet/u1/a.csv", "u1")]
    with local("memory://er_fleet/u1/a.csv") as place:
        assert place.read_bytes() == b"t,deflection\n0,1\n"
        assert content(place)
    assert not place.exists()
    before = token("memory://er_fleet/u1/a.csv")
    files.pipe("/er_fleet/u1/a.csv", b"t,deflection\n0,2\n3,4\n")
    assert token("memory://er_fleet/u1/a.csv") != before
    with pytest.raises(lab.InputError, match="a protocol that fsspec reads"):
        list(sources(["nowhere://a"]))


def test_few_recordings_stand_for_many() -> None:
    assert chosen([10] * 5, 20) == [0, 1, 2, 3, 4]
    assert chosen([10] * 100, 5) == [0, 25, 50, 74, 99]
    assert chosen([MOST_SAMPLES // 2] * 9, 5) == [0, 8]
    assert chosen([2 * MOST_SAMPLES], 5) == [0]
    assert chosen([], 5) == []


def twice(job: int, asked: Asked) -> int:
    """A job of tests: odd numbers end badly."""
    if job == 7:
        raise ValueError("seven")
    if job == 8:
        raise lab.InputError("eight", "", "a number", "8")
    return 2 * job


def done_by(engine: Engine, numbers: int = 10) -> dict[int, object]:
    """What an engine makes of numbers."""
    found: dict[int, object] = {}

    def told(number: int, result: object) -> None:
        assert number not in found
        found[number] = result

    spread(engine, twice, ((k, k) for k in range(numbers)), ASKED, told, lambda: None)
    return found


def test_every_job_is_done_once_and_a_failure_ends_no_fleet(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with ThreadPoolExecutor(2) as pool:
        found = done_by(Engine(pool, 2))
    wrong = {
        7: Failure("ValueError: seven"),
        8: Failure("eight: expected a number, found 8", kept=True),
    }
    assert found == {k: 2 * k for k in range(10)} | wrong
    with ThreadPoolExecutor(1) as pool:
        monkeypatch.setitem(code(), "numpy", "0.1")
        sealed = engines.pickle.dumps((twice, ASKED, {**code(), "numpy": "9"}))
        with pytest.raises(OtherCode, match=r"numpy 0\.1 instead of 9"):
            engines.work([(0, 0)], sealed)


class Dies(Executor):
    """Loses what it has to do the first times; a batch with the poison kills whoever takes it."""

    def __init__(self, times: int, how: Exception, poison: int | None = None) -> None:
        self.times, self.how, self.poison, self.most = times, how, poison, 0

    def submit(self, fn, /, *args, **more):  # type: ignore[no-untyped-def]
        future: Future[object] = Future()
        batch = args[0]
        self.most = max(self.most, len(batch))
        if any(number == self.poison for number, _ in batch) or self.times > 0:
            self.times -= 1
            future.set_exception(self.how)
        else:
            future.set_result(fn(*args, **more))
        return future


class Killed(Exception):
    """A worker died."""


def test_what_is_lost_is_handed_out_again_and_a_poisoned_job_stands_alone() -> None:
    poisoned = Dies(0, Killed("worker"), poison=3)
    found = done_by(Engine(poisoned, 1, died=lambda e: isinstance(e, Killed)), 50)
    assert found.pop(3) == Failure("Killed: worker")
    assert found.keys() == {*range(50)} - {3}
    assert poisoned.most > 1
    gone = Dies(3, Lost())
    assert done_by(Engine(gone, 2, again=lambda: gone), 6) == {k: 2 * k for k in range(6)}
    with pytest.raises(Lost):
        done_by(Engine(Dies(1, Lost()), 1))


def test_a_full_disk_ends_no_run_and_half_a_row_is_none(tmp_path: Path) -> None:
    store = Store(tmp_path / "f.results")
    store.keep("a", [1], ("p", "t", "c"))
    store._db.execute("PRAGMA max_page_count = 1")
    run = Run(store, ASKED, Engine(ThreadPoolExecutor(1), 1), HERE)
    run._keep("b", "x" * 100_000)
    assert "full" in run.lost
    assert (store.kept("a"), store.known("p"), store.kept("b")) == ([1], ("t", "c"), None)
    with pytest.raises(lab.InputError, match="no other run has open"):
        Store(tmp_path / "f.results")
    store.close()
    other = tmp_path / "g.results"
    other.write_text("no database, but long enough to be taken for one" * 20)
    with pytest.raises(lab.InputError, match="a file of results"):
        Store(other)


def test_the_same_samples_count_once_wherever_they_lie(tmp_path: Path) -> None:
    store = Store(tmp_path / "f.results")
    store.add([Source("a", "1"), Source("b", "2"), Source("b", "3")])
    row = {"record": "r", "digest": "d", "status": "used"}
    for number, source in store.sources():
        store.place(number, source, [row])
        store.place(number, source, [row])
    assert [(p["unit"], p["status"], p.get("error")) for p in store.parts()] == [
        ("1", "used", None), ("2", "copy", "the samples of a: used once")
    ]  # fmt: skip


def test_a_unit_that_got_another_damper_changes_where_it_did(tmp_path: Path) -> None:
    rows = []
    for unit in ("a", "b", "c"):
        for k in range(6):
            c0 = 1.8 if (unit, k >= 3) == ("b", True) else 1.0
            path = record(tmp_path / f"{unit}{k}.parquet", seed=10 * ord(unit) + k, c0=c0)
            rows.append(f"{path.name},{unit},{10.0 * k}")
    table = tmp_path / "drives.csv"
    table.write_text("\n".join(["path,unit,mileage [km]", *rows]) + "\n")
    out = tmp_path / "fleet.parquet"
    with ThreadPoolExecutor(1) as pool:
        found = lab.fleet(table, load_model(GUO), out=out, search=False, executor=pool).to_dict()
    assert [each["unit"] for each in found["differ"]] == ["b"]
    units = {row["unit"]: row for row in pq.read_table(out).to_pylist()}
    assert [row["changes"] for row in (units["a"], units["c"])] == [[], []]
    change = next(c for c in units["b"]["changes"] if c["quantity"] == "passive.c0")
    assert change["form"] == "step"
    assert 20e3 <= change["at"] <= 30e3


def test_clocks_that_overlap_are_told() -> None:
    used = [
        {"time": t, "seconds": 60.0, "path": p} for t, p in ((0.0, "a"), (30.0, "b"), (100.0, "c"))
    ]
    assert _overlaps(used) == [
        "the times of a and b overlap: a clock is wrong, or these are two units"
    ]
    assert _overlaps([{**each, "seconds": 20.0} for each in used]) == []


@pytest.fixture(scope="module")
def yard(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four units of two recordings, one of them damaged, one empty, one a copy."""
    folder = tmp_path_factory.mktemp("yard")
    for k in range(4):
        for j in range(2):
            record(folder / f"u{k}" / f"{j}.parquet", 10 * k + j, seconds=3.0, c0=1.0 + 0.02 * k)
    (folder / "u0" / "2.parquet").write_bytes((folder / "u0" / "0.parquet").read_bytes()[:3000])
    (folder / "u1" / "2.csv").touch()
    (folder / "u2" / "2.parquet").write_bytes((folder / "u3" / "0.parquet").read_bytes())
    return folder


def test_a_fleet_has_one_row_a_unit_and_one_a_recording(yard: Path, tmp_path: Path) -> None:
    out = tmp_path / "fleet.parquet"
    with ThreadPoolExecutor(1) as pool:
        found = lab.fleet(yard, lab.load_model("inove_guo"), out=out, search=False, executor=pool)
    rows, parts = (pq.read_table(f) for f in (found.table, found.recordings_table))
    assert rows.schema.field("passive.c0").metadata[b"unit"] == b"N s/m"
    assert rows.column_names[:4] == ["unit", "verdict", "effects", "alternatives"]
    assert [(r["unit"], r["recordings"], r["left_out"]) for r in rows.to_pylist()] == [
        ("u0", 2, 1), ("u1", 2, 1), ("u2", 3, 0), ("u3", 1, 1)
    ]  # fmt: skip
    told = {
        (p["unit"], Path(p["path"]).name): (p["status"], p["error"]) for p in parts.to_pylist()
    }
    assert told["u0", "2.parquet"][0] == told["u1", "2.csv"][0] == "unreadable"
    assert "an empty file" in told["u1", "2.csv"][1]
    assert told["u3", "0.parquet"] == ("copy", f"the samples of {yard}/u2/2.parquet: used once")
    assert not found.complete
    assert found.to_dict()["statuses"] == {
        "used": 8,
        "unreadable": 2,
        "copy": 1,
    }
    json.dumps(found.to_dict(), allow_nan=False)
    for row in rows.to_pylist()[:3]:
        own, sd = row["passive.c0_pooled"], row["passive.c0_pooled_sd"]
        assert abs(own - load_model(GUO).effects["passive"]["c0"]) < 5.0 * sd + 3.0
    (yard / "u0" / "1.parquet").touch()
    with ThreadPoolExecutor(1) as pool:
        once_more = lab.fleet(
            yard, lab.load_model("inove_guo"), out=out, search=False, resume=True, executor=pool
        )
    assert once_more.to_dict()["reused"] == 11
    assert pq.read_table(out) == rows


def test_what_was_done_before_an_interruption_is_not_repeated(yard: Path, tmp_path: Path) -> None:
    asked: dict[str, Any] = {"out": tmp_path / "fleet.parquet", "search": False}

    def stop(stage: str, done: int, *_: object) -> None:
        if done == 3:
            raise KeyboardInterrupt

    with ThreadPoolExecutor(1) as pool:
        first = lab.fleet(yard, lab.load_model("inove_guo"), executor=pool, progress=stop, **asked)
    assert first.interrupted
    assert "resume=True goes on" in first.notes[0]
    assert pq.read_table(first.recordings_table).num_rows == 3
    with ThreadPoolExecutor(1) as pool:
        second = lab.fleet(yard, lab.load_model("inove_guo"), executor=pool, resume=True, **asked)
    assert (second.to_dict()["reused"], second.to_dict()["recordings"]) == (3, 11)


def test_what_a_recording_does_not_show_has_no_small_deviation(tmp_path: Path) -> None:
    """Without a duty neither the yield force nor its response time is there."""
    found = recording(
        RecordingJob(str(record(tmp_path / "u" / "r.parquet", 3, seconds=3.0, duty=0.0)), "u"),
        ASKED,
    )
    values = found["rows"][0]["values"]
    for name in ("guo_yield.f_c", "response.tau"):
        value, sd, _ = values[name]
        assert sd is None or sd > abs(value)
    value, sd, _ = values["passive.c0"]
    assert sd < 0.1 * value


def test_a_unit_that_lacks_something_is_named(tmp_path: Path) -> None:
    record(tmp_path / "d" / "u" / "1.parquet", 5, friction=1.0)
    seen: list[str] = []
    with ThreadPoolExecutor(1) as pool:
        found = lab.fleet(
            tmp_path / "d", lab.load_model("inove_guo"), out=tmp_path / "f.parquet", executor=pool,
            progress=lambda stage, *_: seen.append(stage),
        )  # fmt: skip
    (row,) = pq.read_table(found.table).to_pylist()
    assert row["verdict"] in ("missing_effect", "ambiguous")
    assert row["effects"] == ["coulomb_friction"]
    assert row["rmse"] > 2.0 * row["rmse_after"]
    assert seen == ["recordings", "units"]
    assert {"coulomb_friction.F_c", "passive.c0"} <= {v["name"] for v in row["values"]}


def test_what_is_wrong_is_one_line_and_nothing_is_written(tmp_path: Path) -> None:
    model = lab.load_model("inove_guo")
    with pytest.raises(lab.InputError, match="ends in"):
        lab.fleet(tmp_path, model, out=tmp_path / "fleet.csv")
    with pytest.raises(lab.InputError, match="at least one recording"):
        lab.fleet(tmp_path, model, out=tmp_path / "f.parquet", executor=ThreadPoolExecutor(1))
    assert not (tmp_path / "f.parquet").exists()
    assert sqlite3.sqlite_version_info >= (3, 24)


def test_a_parameter_is_drawn_and_tabled_in_the_unit_it_is_labelled_with() -> None:
    """A yield deflection of 74 um: values, common value and spreads are in micrometres, as the title says."""
    name = "bouc_wen_hysteresis.z_y"
    rows = [
        {"pooled": {name: [7e-5 + 1e-6 * k, 1e-6]}, "values": {name: [8e-5, 1e-6]}}
        for k in range(5)
    ]
    known = {"mean": 7.4e-5, "sd": 3e-5, "unit": "m", "between": 6.7e-5, "within": 0.0, "units": 5}
    view = SimpleNamespace(
        result={"parameters": {name: known}}, fleet=SimpleNamespace(rows=rows, total=5)
    )
    drawn = parameters(cast(Any, view))
    assert drawn is not None
    (panel,) = drawn.figures[0].panels
    own, pooled, common = panel.marks
    assert panel.title == f"{name} [\N{MICRO SIGN}m]"
    assert np.allclose(own.y, 80.0)
    assert np.allclose(pooled.y, 70.0 + np.arange(5))
    assert common.value == pytest.approx(74.0)
    assert drawn.facts["rows"][0][1:3] == (
        "74 \N{PLUS-MINUS SIGN} 30 \N{MICRO SIGN}m",
        "67.0 \N{MICRO SIGN}m",
    )
