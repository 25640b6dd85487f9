"""A fleet whose disk is full, whose workers die, whose data are bad: with real disks, processes and signals."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path
from typing import Any

import psutil
import pytest

pytest.importorskip("pyarrow")

import pyarrow.parquet as pq
from er_model_lab.fleets.asked import Asked
from er_model_lab.fleets.cluster import cluster
from er_model_lab.fleets.engine import Engine, Failure, spread
from er_model_lab.fleets.run import Run
from er_model_lab.fleets.source import Source
from er_model_lab.fleets.store import Store
from er_model_lab.work import HERE
from test_fleet import ASKED, Leaves, record

import er_model_lab as lab

DAY = 86400.0

FULL = """
import json, os, sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

place, data = map(Path, sys.argv[1:])
for folder in ("out", "tmp"):
    (place / folder).mkdir()
    os.system(f"mount -t tmpfs -o size=600k none {place / folder}")
os.environ["TMPDIR"] = str(place / "tmp")
import er_model_lab as lab


def filled(stage, done, *_):
    if done == 2:
        for folder in ("out", "tmp"):
            with suppress(OSError), (place / folder / "filler").open("wb", buffering=0) as file:
                while True:
                    file.write(bytes(512))


asked = dict(out=place / "out" / "fleet.parquet", search=False)
with ThreadPoolExecutor(1) as pool:
    found = lab.fleet(data, lab.load_model("inove_guo"), executor=pool, progress=filled, **asked)
    print(json.dumps({"errors": [*map(str, found.errors)], **found.to_dict()}))
    for folder in ("out", "tmp"):
        (place / folder / "filler").unlink()
    again = lab.fleet(data, lab.load_model("inove_guo"), executor=pool, resume=True, **asked)
    print(json.dumps({"errors": [*map(str, again.errors)], **again.to_dict()}))
"""


def mounts() -> bool:
    """Whether this user may mount a file system of his own."""
    if shutil.which("unshare") is None:
        return False
    tried = ["unshare", "-Urm", "mount", "-t", "tmpfs", "none", "/mnt"]
    return subprocess.run(tried, capture_output=True, check=False).returncode == 0


@pytest.mark.slow
@pytest.mark.skipif(not mounts(), reason="no file system of one's own")
def test_a_disk_that_is_really_full_ends_no_run(tmp_path: Path) -> None:
    """Results, tables and temporary files have no room left from the second recording on."""
    for k in range(5):
        record(tmp_path / "data" / "u" / f"{k}.parquet", k, seconds=3.0)
    (tmp_path / "full.py").write_text(FULL)
    words = ["unshare", "-Urm", sys.executable, tmp_path / "full.py", tmp_path, tmp_path / "data"]
    ended = subprocess.run(words, capture_output=True, text=True, timeout=300, check=False)
    assert ended.returncode == 0, ended.stderr
    first, again = map(json.loads, ended.stdout.splitlines())
    assert first["statuses"] == again["statuses"] == {"used": 5}
    out = tmp_path / "out"
    for error, name in zip(first["errors"], ("fleet", "fleet.recordings"), strict=True):
        assert error.startswith(
            f"{out}/{name}.parquet: --out: expected a place that can be written"
        )
        assert error.endswith("No space left on device")
    said = "\n".join(first["notes"])
    assert f"{out}/fleet.results could not be written (database or disk is full)" in said
    assert "rows stayed in memory" in said
    assert (first["tables"], first["complete"], again["complete"]) == ({}, False, True)
    assert 1 <= again["reused"] < 5
    assert again["tables"].keys() == {"units", "recordings"}


@pytest.fixture(scope="module")
def bad(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A table of three units: one gets another damper; a damaged, an empty, a copied and an overlapping recording."""
    folder = tmp_path_factory.mktemp("bad")
    rows = []
    for unit, number in (("a", 3), ("b", 6), ("c", 3)):
        for k in range(number):
            c0 = 1.8 if unit == "b" and k >= 3 else 1.0
            path = record(folder / f"{unit}{k}.parquet", 10 * ord(unit) + k, seconds=3.0, c0=c0)
            rows.append([path.name, unit, k * DAY, 10.0 * k])
    rows[1][2] = rows[0][2] + 1.0
    whole = (folder / "a0.parquet").read_bytes()
    for name, content in (("damaged", whole[:3000]), ("empty", b""), ("copy", whole)):
        (folder / f"{name}.parquet").write_bytes(content)
        rows.append([f"{name}.parquet", "c", 9 * DAY, 90.0])
    lines = [",".join(map(str, row)) for row in rows]
    (folder / "drives.csv").write_text("\n".join(["path,unit,time,mileage [km]", *lines]))
    return folder / "drives.csv"


@pytest.fixture(scope="module")
def undisturbed(bad: Path, tmp_path_factory: pytest.TempPathFactory) -> lab.FleetResult:
    """The fleet in a plain loop."""
    out = tmp_path_factory.mktemp("plain") / "fleet.parquet"
    with ThreadPoolExecutor(1) as pool:
        return lab.fleet(bad, lab.load_model("inove_guo"), out=out, search=False, executor=pool)


def tables(found: lab.FleetResult) -> list[list[dict[str, Any]]]:
    """The rows of both tables."""
    return [pq.read_table(f).to_pylist() for f in (found.table, found.recordings_table)]


def workers() -> list[psutil.Process]:
    """Processes of Dask that this one started."""
    every = psutil.Process().children(recursive=True)
    return [p for p in every if "spawn_main" in " ".join(p.cmdline())]


def test_the_plain_loop_tells_what_is_bad(undisturbed: lab.FleetResult) -> None:
    """So that equal tables say something."""
    units, recordings = tables(undisturbed)
    a, b, c = units
    assert [(u["recordings"], u["left_out"]) for u in units] == [(3, 0), (6, 0), (3, 3)]
    assert a["notes"][0].startswith("the times of ")
    damping = {c["axis"]: c for c in b["changes"] if c["quantity"] == "passive.c0"}
    assert (damping["mileage"]["form"], damping["time"]["form"]) == ("step", "step")
    assert 20e3 <= damping["mileage"]["at"] <= 30e3
    assert 2 * DAY <= damping["time"]["at"] <= 3 * DAY
    assert (a["changes"], c["changes"]) == ([], [])
    status = {Path(r["path"]).stem: r["status"] for r in recordings if r["status"] != "used"}
    assert status == {"damaged": "unreadable", "empty": "unreadable", "copy": "copy"}


def test_a_killed_worker_and_bad_recordings_change_no_table(
    bad: Path, undisturbed: lab.FleetResult, tmp_path: Path
) -> None:
    """On Dask's processes, one of them killed in the middle; then --resume, where nobody may work."""
    killed: list[int] = []

    def kill(stage: str, done: int, *_: object) -> None:
        if done == 3 and not killed:
            killed.append(workers()[0].pid)
            os.kill(killed[0], signal.SIGKILL)

    asked: dict[str, Any] = {"out": tmp_path / "fleet.parquet", "search": False}
    model = lab.load_model("inove_guo")
    found = lab.fleet(bad, model, workers=2, progress=kill, **asked)
    assert killed
    assert tables(found) == tables(undisturbed)
    assert workers() == []
    again = lab.fleet(bad, model, executor=Leaves(0), resume=True, **asked)
    assert again.to_dict()["reused"] == again.to_dict()["recordings"] == 15
    assert tables(again) == tables(undisturbed)


def poisoned(job: int, asked: Asked) -> int:
    """A job of tests: number five kills whoever takes it."""
    if job == 5:
        os.kill(os.getpid(), signal.SIGKILL)
    return job


@pytest.mark.slow
def test_a_job_that_kills_every_worker_stands_alone_as_a_failure() -> None:
    """Dask gives it up, for real."""
    told: dict[int, Any] = {}
    with cluster(None, workers=2) as engine:
        spread(
            engine, poisoned, ((k, k) for k in range(40)), ASKED, told.__setitem__, lambda: None
        )
    failure = told.pop(5)
    assert isinstance(failure, Failure)
    assert failure.said.startswith("KilledWorker")
    assert not failure.kept
    assert told == {k: k for k in range(40) if k != 5}


@pytest.mark.slow
def test_ctrl_c_to_the_whole_command_keeps_all(
    bad: Path, undisturbed: lab.FleetResult, tmp_path: Path
) -> None:
    """A terminal sends it to every process of the command."""
    table = tmp_path / "fleet.parquet"
    words = [
        sys.executable,
        "-m",
        "er_model_lab.cli.app",
        "fleet",
        bad,
        "--model",
        "inove_guo",
        "--out",
        table,
    ]
    command = [*map(str, words), "--no-search", "--workers", "1"]
    log = tmp_path / "fleet.results-wal"
    running = subprocess.Popen(command, start_new_session=True, stderr=subprocess.PIPE, text=True)
    end = time.monotonic() + 120.0
    while (
        running.poll() is None
        and time.monotonic() < end
        and not (log.exists() and log.stat().st_size > 30_000)
    ):
        time.sleep(0.02)
    os.killpg(running.pid, signal.SIGINT)
    _, said = running.communicate(timeout=60)
    assert running.returncode == 130, said
    assert "Traceback" not in said
    done = pq.read_table(tmp_path / "fleet.recordings.parquet").num_rows
    assert 1 <= done < 15
    asked: dict[str, Any] = {"out": table, "search": False, "resume": True}
    with ThreadPoolExecutor(1) as pool:
        found = lab.fleet(bad, lab.load_model("inove_guo"), executor=pool, **asked)
    assert found.to_dict()["reused"] >= done
    assert tables(found) == tables(undisturbed)


@pytest.mark.slow
def test_a_page_of_a_unit_shows_its_diagnosis(tmp_path: Path) -> None:
    path = record(tmp_path / "u.parquet", 5, seconds=5.0, friction=1.0)
    with closing(Store(tmp_path / "f.results")) as store, ThreadPoolExecutor(1) as pool:
        run = Run(store, ASKED, Engine(pool, 1), HERE, room=1000)
        store.add([Source(str(path), "u")])
        run.recordings()
        run.units()
        path.unlink()  # a second diagnosis would need it
        (page,) = run.pages(["u"]).values()
    assert page.startswith(b"<!DOCTYPE html>")
    assert b"Coulomb friction" in page
