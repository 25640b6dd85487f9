"""Times and memory of a fleet, done in a plain loop and by Dask's workers, and what the client and a scheduler cost."""

from __future__ import annotations

import asyncio
import io
import pickle
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import psutil
from er_common.port import HOST, free_port
from er_model_lab.fleets.asked import Asked
from er_model_lab.fleets.cluster import ONE, cluster
from er_model_lab.fleets.engine import Engine, later, seal, work
from er_model_lab.fleets.fleet import fleet
from er_model_lab.fleets.recording import RecordingJob, recording
from er_model_lab.fleets.run import Run
from er_model_lab.fleets.source import Source
from er_model_lab.fleets.store import Store
from er_model_lab.work import HERE
from er_models.model import Array, Model
from joblib.externals.loky import ProcessPoolExecutor

from er_studies.bench.fleet.cluster import Costs, simulated

LOOK = 0.2
"""How often memory is looked at [s]."""
MB = 1e6
BATCHES = 2000
"""Empty batches from which their cost is measured."""


@dataclass(frozen=True)
class Line:
    """One run.

    wall, processor: times, the latter of all processes [s]; first, last: the largest worker in the first and in the
    last third of the run [MB]; client: at its end [MB]; found: what was found.
    """

    what: str
    wall: float
    processor: float
    first: float
    last: float
    client: float
    found: str


class Loop(Executor):
    """Does what it is given at once, in this thread: a plain loop."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """The result, as a future that is done."""
        done: Future[Any] = Future()
        done.set_result(fn(*args, **kwargs))
        return done


class _Jobs(pickle.Unpickler):
    """Reads which jobs a call is for, and does none."""

    def find_class(self, module: str, name: str) -> Any:
        """The batch itself in place of what does it."""
        return (
            (lambda batch, _: batch) if name == work.__name__ else super().find_class(module, name)
        )


class Answers(Executor):
    """Knows every result beforehand: what is left is what the client does."""

    def __init__(self, row: Any, seconds: float) -> None:
        """The answer to every recording, and how long it takes at a worker [s]."""
        self._row, self._seconds = row, seconds

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """The answers to a batch."""
        del fn, kwargs
        batch, done = _Jobs(io.BytesIO(args[0])).load(), Future[Any]()
        found = [
            {"content": job.path, "rows": [{**r, "digest": job.path} for r in self._row["rows"]]}
            for _, job in batch
        ]
        done.set_result((found, self._seconds * len(batch)))
        return done


def compared(
    data: Path, model: Model, workers: Sequence[int], *, search: bool, said: Callable[[str], Any]
) -> list[Line]:
    """The fleet in a plain loop (0 workers), and by so many workers of Dask; each in a folder of its own.

    Each does half of the units in this order and the other half in the opposite one: a machine whose speed drifts
    favours none. The loop runs in a process with one thread, as each worker has; its start is not counted. said: hears
    a line for each half.
    """
    units = sorted(data.glob("unit*"))
    halves = [half for half in (units[::2], units[1::2]) if half]
    found: dict[int, list[Line]] = {number: [] for number in workers}
    for k, half in enumerate(halves):
        for number in workers[:: -1 if k % 2 else 1]:
            line = _alone(half, model, number, search=search)
            said(f"{line.what}, {len(half)} units: {line.wall:.1f} s")
            found[number].append(line)
    return [_sum(lines) for lines in found.values()]


def _alone(units: Sequence[Path], model: Model, number: int, *, search: bool) -> Line:
    """One run: by workers, or as a loop in a process of its own."""
    if number:
        return _line(units, model, number, search=search)
    with ProcessPoolExecutor(1, env=ONE) as pool:
        found: Line = pool.submit(_line, units, model, 0, search=search).result()
    return found


def _sum(lines: Sequence[Line]) -> Line:
    """Runs that did a part each, as one."""
    return Line(
        lines[0].what, sum(r.wall for r in lines), sum(r.processor for r in lines), max(r.first for r in lines),
        max(r.last for r in lines), max(r.client for r in lines), "; ".join(r.found for r in lines),
    )  # fmt: skip


def _line(units: Sequence[Path], model: Model, number: int, *, search: bool) -> Line:
    """One run in this process, with so many workers or none."""
    executor = None if number else Loop()
    with tempfile.TemporaryDirectory() as place, _memory() as seen:
        before, begun = _processor(), time.perf_counter()
        result = fleet(
            units, model, out=Path(place) / "fleet.parquet", search=search, workers=number or 1,
            executor=executor,
        )  # fmt: skip
        wall, used = time.perf_counter() - begun, _processor() - before
    what = f"{number} worker{'s' * (number > 1)}" if number else "plain loop"
    return Line(what, wall, used + seen.used, *seen.thirds(), seen.client, result.view.headline)


class _Seen:
    """Memory of this process and of those that it started [MB], and the processor time of the latter [s]."""

    def __init__(self) -> None:
        """Nothing was seen yet."""
        self.workers: list[float] = []
        self.client = 0.0
        self.times: dict[int, float] = {}

    @property
    def used(self) -> float:
        """Processor time of all processes that this one started [s]."""
        return sum(self.times.values())

    def look(self) -> None:
        """Look once."""
        sizes = [0.0]
        for process in psutil.Process().children(recursive=True):
            try:
                times = process.cpu_times()
                self.times[process.pid] = times.user + times.system
                sizes.append(process.memory_info().rss / MB)
            except psutil.Error:
                continue
        self.workers.append(max(sizes))
        self.client = psutil.Process().memory_info().rss / MB

    def thirds(self) -> tuple[float, float]:
        """The largest worker in the first and in the last third [MB]."""
        part = max(1, len(self.workers) // 3)
        return max(self.workers[:part]), max(self.workers[-part:])


@contextmanager
def _memory() -> Iterator[_Seen]:
    """Look at memory while something goes on."""
    seen, end = _Seen(), threading.Event()

    def watch() -> None:
        """Look until the end."""
        while not end.wait(LOOK):
            seen.look()

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    try:
        yield seen
    finally:
        end.set()
        thread.join()


def _processor() -> float:
    """Processor time of this process so far [s]."""
    return time.process_time()


def recorded(data: Path, model: Model, number: int) -> tuple[Array, Any]:
    """Times of so many recordings at a worker (n,) [s], and what the last of them gives; the first warms up."""
    asked, seconds, found = Asked(model), [], None
    for file in sorted(data.rglob("*.parquet"))[: number + 1]:
        begun = time.perf_counter()
        found = recording(RecordingJob(str(file), "unit"), asked)
        seconds.append(time.perf_counter() - begun)
    return np.array(seconds[1:]), found


def client(model: Model, row: Any, number: int) -> tuple[float, float]:
    """Processor time of the client for a recording [s], and what so many of them add to its memory [MB]."""
    engine = Engine(Answers(row, 0.3), 1000)
    with tempfile.TemporaryDirectory() as place:
        store = Store(Path(place) / "fleet.results")
        store.add(Source(f"{k:07d}.parquet", f"unit{k // 100}") for k in range(number))
        run = Run(store, Asked(model), engine, HERE)
        before, size = time.process_time(), psutil.Process().memory_info().rss
        run.recordings()
        seconds = (time.process_time() - before) / number
        grown = (psutil.Process().memory_info().rss - size) / MB
        store.close()
    return seconds, grown


def costs(model: Model, times: Array, each: float) -> Costs:
    """What a batch costs the client and a scheduler of its own here, with workers that have nothing to do.

    The scheduler's messages that the simulation counts by itself are taken off; what is left is passing a result on.
    """
    address = f"tcp://{HOST}:{free_port()}"
    with tempfile.TemporaryDirectory() as place:
        scheduler = _started("scheduler", "--host", address, "--no-dashboard")
        worker = _started(
            "worker",
            address,
            "--nthreads",
            "1",
            "--no-nanny",
            "--no-dashboard",
            "--local-directory",
            place,
        )
        try:
            with cluster(address) as engine:
                _empty(engine, model, 200)
                before = psutil.Process(scheduler.pid).cpu_times()
                begun = time.process_time()
                _empty(engine, model, BATCHES)
                batch = (time.process_time() - begun) / BATCHES
                after = psutil.Process(scheduler.pid).cpu_times()
        finally:
            for process in (worker, scheduler):
                process.kill()
                process.wait()
    whole = (after.user + after.system - before.user - before.system) / BATCHES
    free = Costs(0.0, 0.0, 0.0, np.array([1.0]))
    alone = asyncio.run(simulated(10, BATCHES, free))  # batches of two seconds: two recordings
    counted = alone.scheduler * alone.seconds / alone.batches
    return Costs(batch, each, max(0.0, whole - counted), times)


def _empty(engine: Engine, model: Model, number: int) -> None:
    """So many batches with one job that is nothing."""
    sealed = seal(nothing, Asked(model))
    for future in [
        engine.executor.submit(pickle.loads, later(work, [(k, k)], sealed)) for k in range(number)
    ]:
        future.result()


def nothing(job: int, asked: Asked) -> int:
    """A job without work."""
    del asked
    return job


def _started(kind: str, *words: str) -> subprocess.Popen[bytes]:
    """A scheduler or a worker in a process of its own."""
    command = [sys.executable, "-m", f"distributed.cli.dask_{kind}", *words]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
