"""A fleet without a cluster: where recordings are found, how jobs are handed out, what is kept, what rows become."""

from __future__ import annotations

import json
import sqlite3
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import closing, nullcontext
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from types import SimpleNamespace
from typing import Any, ClassVar, cast

import numpy as np
import pytest

pytest.importorskip("fsspec")
pytest.importorskip("pyarrow")

import pyarrow as pa
import pyarrow.parquet as pq
from er_model_lab.cli import running
from er_model_lab.cli.app import app
from er_model_lab.fleets import cluster as clusters
from er_model_lab.fleets import engine as engines
from er_model_lab.fleets import run as runs
from er_model_lab.fleets import unit as units
from er_model_lab.fleets.asked import Asked, code
from er_model_lab.fleets.engine import Engine, Failure, Lost, OtherCode, spread
from er_model_lab.fleets.recording import RecordingJob, recording
from er_model_lab.fleets.run import Run, _overlaps
from er_model_lab.fleets.source import Source, sources
from er_model_lab.fleets.store import Store
from er_model_lab.fleets.trends import trend
from er_model_lab.fleets.two_groups import two_groups
from er_model_lab.fleets.unit import MOST_SAMPLES, UnitJob, chosen
from er_model_lab.output.report.sections.fleet import parameters
from er_model_lab.work import HERE
from er_models.files import load_model
from er_models.prediction import motion, predict
from lab_help import DT, FORCE_NOISE, GUO, imposed
from typer.testing import CliRunner

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


class Quiet(SimpleHTTPRequestHandler):
    """Serves a folder without a word, and counts what is sent."""

    sent: ClassVar[list[str]] = []

    def log_message(self, *_: object) -> None:
        """Nothing."""

    def do_GET(self) -> None:
        self.sent.append(self.path)
        super().do_GET()


def test_a_fleet_behind_http_is_read_where_it_lies(tmp_path: Path) -> None:
    """A folder, and a list as Parquet; what changed on the server is read again, what did not is not sent."""
    pytest.importorskip("aiohttp")
    yard = tmp_path / "yard"
    for name in ("a/1", "b/2"):
        record(yard / f"{name}.parquet", len(name), seconds=3.0, c0=1.0 + 0.1 * (name == "b/2"))
    pq.write_table(
        pa.table({
            "path": ["a/1.parquet", "b/2.parquet", "b/gone.parquet"], "unit": ["x", "y", "y"],
            "mileage": [1.0, 2.0, None],
        }),
        yard / "list.parquet",
    )  # fmt: skip
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(yard)))
    Thread(target=server.serve_forever, daemon=True).start()
    url = f"http://127.0.0.1:{server.server_port}"
    asked: dict[str, Any] = {"out": tmp_path / "fleet.parquet", "search": False}

    def told(
        *, resume: bool = False
    ) -> tuple[list[tuple[str, str, float | None]], int, list[str]]:
        """Unit, status and mileage of each recording; how many were reused; what was sent."""
        Quiet.sent.clear()
        with ThreadPoolExecutor(1) as pool:
            found = lab.fleet(
                f"{url}/list.parquet", load_model(GUO), executor=pool, resume=resume, **asked
            )
        rows = pq.read_table(found.recordings_table).to_pylist()
        sent = sorted(each for each in Quiet.sent if "list" not in each and "gone" not in each)
        return (
            [(r["unit"], r["status"], r["mileage"]) for r in rows],
            found.to_dict()["reused"],
            sent,
        )

    try:
        assert inside(f"{url}/a/") == [("1.parquet", "a")]
        rows, _, sent = told()
        assert rows == [("x", "used", 1.0), ("y", "unreadable", None), ("y", "used", 2.0)]
        assert sent == ["/a/1.parquet", "/b/2.parquet"]
        assert told(resume=True) == (rows, 2, [])
        record(yard / "a/1.parquet", 9, seconds=3.5)
        assert told(resume=True) == (rows, 1, ["/a/1.parquet"])
    finally:
        server.shutdown()
        server.server_close()
    with pytest.raises(lab.ErError, match=f"^{url}/list.parquet: .*[Cc]onnect"):
        told()


def test_what_cannot_be_fetched_now_has_failed_and_is_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A network that times out is no answer: neither the recording nor its unit is bad for ever."""
    import fsspec

    files = fsspec.filesystem("memory")
    files.pipe("/er_away/u/a.parquet", record(tmp_path / "a.parquet", 1, seconds=3.0).read_bytes())
    url = "memory:///er_away/u/a.parquet"
    asked: dict[str, Any] = {"out": tmp_path / "f.parquet", "search": False}

    def rows(*, resume: bool) -> tuple[dict[str, Any], int]:
        """The row of the recording, and how many were reused."""
        with ThreadPoolExecutor(1) as pool:
            found = lab.fleet(
                "memory://er_away",
                lab.load_model("inove_guo"),
                executor=pool,
                resume=resume,
                **asked,
            )
        (row,) = pq.read_table(found.recordings_table).to_pylist()
        return row, found.to_dict()["reused"]

    def away(*_: object, **__: object) -> None:
        raise TimeoutError(110, "Connection timed out")

    with monkeypatch.context() as network:
        network.setattr(type(files), "get_file", away)
        row, _ = rows(resume=False)
        assert (row["status"], row["error"]) == ("failed", f"{url}: Connection timed out")
    row, reused = rows(resume=True)
    assert (row["status"], reused) == ("used", 0)
    job = UnitJob("u", (url,), frozenset([row["digest"]]))
    with monkeypatch.context() as network:
        network.setattr(type(files), "get_file", away)
        assert engines._done(units.unit, job, ASKED) == Failure(f"{url}: Connection timed out")
    files.pipe("/er_away/u/a.parquet", record(tmp_path / "b.parquet", 2, seconds=3.0).read_bytes())
    said = "records of u changed since they were first read (1 of 1)"
    assert engines._done(units.unit, job, ASKED) == Failure(said)
    files.rm("/er_away/u/a.parquet")
    files.pipe("/er_away/u/b.csv", b"")
    row, _ = rows(resume=False)
    assert row["status"] == "unreadable"


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
        sealed = engines.pickle.dumps(({**code(), "numpy": "9"}, b"of a class that is not here"))
        with pytest.raises(OtherCode, match=r"numpy 0\.1 instead of 9"):
            engines.work([(0, 0)], sealed)
    with pytest.raises(OtherCode, match=r"cannot begin \(No module named er_model_lab\)"):
        done_by(Engine(Dies(1, ModuleNotFoundError("No module named er_model_lab")), 1))


class Dies(Executor):
    """Loses what it has done the first times; a batch with the poison for a result kills whoever takes it."""

    def __init__(self, times: int, how: Exception, poison: int | None = None) -> None:
        self.times, self.how, self.poison, self.most = times, how, poison, 0

    def submit(self, fn, /, *args, **more):  # type: ignore[no-untyped-def]
        future: Future[object] = Future()
        found, _ = ended = fn(*args, **more)
        self.most = max(self.most, len(found))
        if any(result == self.poison for result in found) or self.times > 0:
            self.times -= 1
            future.set_exception(self.how)
        else:
            future.set_result(ended)
        return future


class Killed(Exception):
    """A worker died."""


def test_what_is_lost_is_handed_out_again_and_a_poisoned_job_stands_alone() -> None:
    poisoned = Dies(0, Killed("worker"), poison=6)
    found = done_by(Engine(poisoned, 1, died=lambda e: isinstance(e, Killed)), 50)
    assert found.pop(3) == Failure("Killed: worker")
    assert found.keys() == {*range(50)} - {3}
    assert poisoned.most > 1
    gone = Dies(3, Lost())
    assert done_by(Engine(gone, 2, again=lambda: gone), 6) == {k: 2 * k for k in range(6)}
    with pytest.raises(Lost):
        done_by(Engine(Dies(1, Lost()), 1))


class Leaves(Executor):
    """Does some batches, then it is gone."""

    def __init__(self, batches: int) -> None:
        self.left = batches

    def submit(self, fn, /, *args, **more):  # type: ignore[no-untyped-def]
        future: Future[object] = Future()
        self.left -= 1
        if self.left < 0:
            future.cancel()
            future.set_running_or_notify_cancel()
        else:
            future.set_result(fn(*args, **more))
        return future


def test_when_the_workers_are_gone_there_are_tables_of_what_they_did(
    yard: Path, tmp_path: Path
) -> None:
    asked: dict[str, Any] = {"out": tmp_path / "fleet.parquet", "search": False}
    model = lab.load_model("inove_guo")
    with pytest.raises(Lost):
        lab.fleet(yard / "u1", model, executor=Leaves(0), **asked)
    found = lab.fleet(yard / "u1", model, executor=Leaves(1), **asked)
    assert [*map(str, found.errors)] == ["the workers are gone"]
    assert (found.complete, found.interrupted) == (False, False)
    assert any("resume=True goes on" in note for note in found.notes)
    done = pq.read_table(found.recordings_table).num_rows
    assert done == 1
    with ThreadPoolExecutor(1) as pool:
        again = lab.fleet(yard / "u1", model, executor=pool, resume=True, **asked)
    assert (again.to_dict()["reused"], again.to_dict()["recordings"]) == (1, 3)


def test_a_cluster_that_grows_gets_more_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engines, "COUNT", 0.0)
    engine = Engine(Dies(0, Killed()), 1, count=lambda: 7)
    assert spread(engine, twice, iter([(1, 1)]), ASKED, print, lambda: None).workers == 7


def test_a_full_disk_ends_no_run_and_half_a_row_is_none(tmp_path: Path) -> None:
    store = Store(tmp_path / "f.results")
    store.keep("a", [1], ("p", "t", "c"))
    store._db.execute("PRAGMA max_page_count = 1")
    run = Run(store, ASKED, Engine(ThreadPoolExecutor(1), 1), HERE)
    run._keep("b", "x" * 100_000)
    assert "full" in run.lost
    assert (store.kept("a"), store.known("p"), store.kept("b")) == ([1], ("t", "c"), None)
    store._db.execute("PRAGMA run.max_page_count = 20")
    store.add([Source(f"{k}", "u") for k in range(40)])
    for number, source in store.sources():
        store.place(
            number,
            source,
            [{"record": "r", "digest": f"{number}", "status": "used", "more": "x" * 3000}],
        )
        store.enter("u", {"last": number})
    assert "full" in store.full
    assert [p["digest"] for p in store.parts("u")] == [f"{k}" for k in range(1, 41)]
    assert [*store.rows()] == [{"unit": "u", "last": 40}]
    with pytest.raises(lab.InputError, match="no other run has open"):
        Store(tmp_path / "f.results")
    store.close()
    other = tmp_path / "g.results"
    other.write_text("no database, but long enough to be taken for one" * 20)
    with pytest.raises(lab.InputError, match="a file of results"):
        Store(other)


@pytest.mark.parametrize("arrival", [(0, 1, 2, 3), (3, 2, 1, 0), (2, 0, 3, 1)], ids=str)
def test_the_same_samples_count_once_whichever_comes_first(
    tmp_path: Path, arrival: tuple[int, ...]
) -> None:
    store = Store(tmp_path / "f.results")
    store.add([Source(name, unit) for name, unit in zip("abccd", "12349", strict=True)])
    status = {"a": "not_usable", "b": "used", "c": "used", "d": "used"}
    named = [*store.sources()]
    for number, source in (*(named[k] for k in arrival), named[0]):
        store.place(
            number, source, [{"record": "r", "digest": "same", "status": status[source.path]}]
        )
    told = [(p["path"], p["status"], p.get("error")) for p in store.parts()]
    said = "the samples of b: used once"
    assert told == [
        ("a", "not_usable", None),
        ("b", "used", None),
        ("c", "copy", said),
        ("d", "copy", said),
    ]
    assert [p["path"] for p in store.parts(status="copy")] == ["c", "d"]
    assert [p["path"] for p in store.parts(status="used")] == ["b"]


def test_a_unit_that_got_another_damper_changes_where_it_did(tmp_path: Path) -> None:
    rows = []
    for unit in ("a", "b", "c", "d"):
        for k in range(6):
            other = {"b": k >= 3, "d": k in (1, 2, 4)}.get(unit, False)
            c0 = 1.8 if other else 1.0
            path = record(tmp_path / f"{unit}{k}.parquet", seed=10 * ord(unit) + k, c0=c0)
            rows.append(f"{path.name},{unit},{10.0 * k}")
    table = tmp_path / "drives.csv"
    table.write_text("\n".join(["path,unit,mileage [km]", *rows]) + "\n")
    out = tmp_path / "fleet.parquet"
    with ThreadPoolExecutor(1) as pool:
        found = lab.fleet(table, load_model(GUO), out=out, search=False, executor=pool).to_dict()
    assert {each["unit"] for each in found["differ"]} == {"b", "d"}
    units = {row["unit"]: row for row in pq.read_table(out).to_pylist()}
    assert [row["changes"] for row in (units["a"], units["c"])] == [[], []]
    change = next(c for c in units["b"]["changes"] if c["quantity"] == "passive.c0")
    assert change["form"] == "step"
    assert 20e3 <= change["at"] <= 30e3
    recordings = pq.read_table(found["tables"]["recordings"]).to_pylist()
    assert [r["damper"] for r in recordings if r["unit"] == "d"] == [1, 2, 2, 1, 2, 1]
    assert {r["damper"] for r in recordings if r["unit"] != "d"} == {None}
    told = next(each for each in found["differ"] if each["unit"] == "d")
    assert "passive.c0 in two groups" in told["in"]
    group = next(c for c in told["changes"] if c["quantity"] == "passive.c0")
    assert (group["form"], group["axis"]) == ("groups", "recordings")
    assert group["low"] < group["at"] < group["high"]


def test_two_dampers_are_told_where_values_fall_into_two_groups_only() -> None:
    rng, turns, one = np.random.default_rng(1), np.arange(20) % 2, np.ones(20)
    chance = [two_groups(y, one, 500) for y in rng.standard_normal((400, 20))]
    assert sum(f is not None and f.p < 0.05 for f in chance) <= 4
    wide = [two_groups(4.0 * y, one, 500) for y in rng.standard_normal((100, 20))]
    assert sum(f is not None and f.p < 0.05 for f in wide) <= 15
    apart = [two_groups(y + 6.0 * turns, one, 500) for y in rng.standard_normal((50, 20))]
    assert sum(f is not None and f.p < 1e-6 and f.low < f.at < f.high for f in apart) >= 47
    once = 6.0 * (turns.cumsum() > 5) + rng.standard_normal(20)
    step = trend(np.arange(20.0), once, one, 500)
    assert step is not None
    exchanged = two_groups(once, one, 500, step.criterion)
    assert exchanged is not None
    assert exchanged.p == 1.0
    outlier = two_groups(np.r_[rng.standard_normal(19), 50.0], one, 500)
    assert outlier is not None
    assert outlier.p == 1.0
    assert two_groups(one[:5], one[:5], 500) is None


def test_clocks_that_overlap_are_told() -> None:
    used = [
        {"time": t, "seconds": 60.0, "path": p} for t, p in ((0.0, "a"), (30.0, "b"), (100.0, "c"))
    ]
    assert _overlaps(used) == [
        "the times of a and b overlap: a clock is wrong, or these are two units"
    ]
    assert _overlaps([{**each, "seconds": 20.0} for each in used]) == []
    used[0] = {**used[0], "seconds": 101.0}
    used[1] = {**used[1], "seconds": 20.0}
    assert _overlaps(used) == [
        "the times of a and b overlap, and 1 more: a clock is wrong, or these are two units"
    ]


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


DRAWN: list[str] = []


def drawn(job: UnitJob, asked: Asked) -> bytes:
    """A page of tests: the unit's name; that of unit b fails."""
    DRAWN.append(job.unit)
    return {"a": b"page of a", "c": b"\xff of c"}[job.unit]


def test_a_page_of_a_unit_is_drawn_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runs, "page", drawn)
    place = tmp_path / "f.results"
    for resume, made in ((False, ["a", "b", "c"]), (True, ["b"]), (False, ["a", "b", "c"])):
        with closing(Store(place)) as store, ThreadPoolExecutor(1) as pool:
            run = Run(store, ASKED, Engine(pool, 1), HERE, resume)
            store.add([Source(name, name) for name in "abcd"])
            for number, source in store.sources():
                status = "not_usable" if source.unit == "d" else "used"
                row = {"record": "r", "digest": source.path, "status": status, "samples": 1}
                store.place(number, source, [{**row, "seconds": 1.0}])
            DRAWN.clear()
            assert run.pages(["a", "b", "c", "d"]) == {"a": b"page of a", "c": b"\xff of c"}
            assert made == DRAWN


def seen(job: UnitJob, asked: Asked) -> tuple[dict[str, Any], bytes]:
    """A diagnosis of tests, with what its page shows."""
    return {"verdict": "adequate"}, f"seen of {job.unit}".encode() if job.keeps else b""


def shown(job: UnitJob, asked: Asked) -> bytes:
    """A page of tests: what it was given to show."""
    return job.seen


def test_a_page_shows_what_its_diagnosis_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While there is room for it; where the temporary disk is full it is found again."""
    monkeypatch.setattr(runs, "unit", seen)
    monkeypatch.setattr(runs, "page", shown)
    with closing(Store(tmp_path / "f.results")) as store, ThreadPoolExecutor(1) as pool:
        run = Run(store, ASKED, Engine(pool, 1), HERE, room=250)
        store.add([Source(name, name) for name in "abc"])
        for number, source in store.sources():
            row = {"record": "r", "digest": source.path, "status": "used", "samples": 100}
            store.place(number, source, [{**row, "seconds": 1.0}])
        run.units()
        assert run.pages("abc") == {"a": b"seen of a", "b": b"seen of b", "c": b""}
        store._into_memory("full")
        assert run.pages("abc") == dict.fromkeys("abc", b"")


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


def test_a_table_that_cannot_be_written_takes_no_other_file_along(
    yard: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The other table, JSON and the screen are there; the end says which file is not."""
    table, pool = tmp_path / "fleet.parquet", ThreadPoolExecutor(1)
    monkeypatch.setattr(clusters, "cluster", lambda *_, **__: nullcontext(Engine(pool, 1)))
    asked = ["fleet", str(yard / "u0"), "--model", str(GUO), "--no-search", "--out", str(table)]

    def full(*args: Any) -> None:
        (table / "is a folder").mkdir(parents=True, exist_ok=True)

    monkeypatch.setattr(running, "writable", full)
    ended = CliRunner().invoke(app, [*asked, "--json", str(tmp_path / "fleet.json")])
    assert ended.exit_code == 2, ended.output
    assert f"{table}: --out: expected a place that can be written" in ended.output.splitlines()[-1]
    told = json.loads((tmp_path / "fleet.json").read_text())
    assert told["tables"] == {"recordings": str(tmp_path / "fleet.recordings.parquet")}
    assert not told["complete"]
    assert pq.read_table(tmp_path / "fleet.recordings.parquet").num_rows == 3
    assert not [*tmp_path.glob(".*")]


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
