"""Jobs of a fleet handed out to an executor: few at a time, so that nothing grows with their number.

An executor is any of `concurrent.futures`; Dask's client gives one. Jobs go in batches of `SECONDS` of work, only
as many as keep every worker busy. Whoever does a batch compares its code with that of who asks.
"""

from __future__ import annotations

import pickle
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, Executor, Future
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import islice
from queue import Empty, SimpleQueue
from typing import Any

from er_models.errors import ErError

from er_model_lab.blas import on_one_thread
from er_model_lab.fleets.asked import Asked, code
from er_model_lab.fleets.places import Unreachable
from er_model_lab.jobs.call import Call

SECONDS, EACH = 2.0, 0.015
"""Work of a batch, and more of it for each worker [s]: long beside what handing it out costs, short beside what is lost
with a worker. No more than seventy batches a second, so that one scheduler hands them out, and a million recordings of
a minute on a thousand workers stay under 100 000 batches.
"""
LARGEST = 200
"""Jobs of a batch, at most."""
AHEAD = 3
"""Batches that are handed out for each worker."""
COUNT = 5.0
"""How often workers are counted [s]: a cluster grows and shrinks."""
LOOK = 0.1
"""How often whoever waits looks whether to stop [s]."""

Job = tuple[int, Any]
"""A number of one's own, and an argument of the function."""
Told = Callable[[int, Any], None]
"""Called with the number of a job that is done, and its result, or a `Failure`."""


@dataclass(frozen=True)
class Failure:
    """Why a job has no result; kept: whether the same would happen again, so that it counts as an answer."""

    said: str
    kept: bool = False


class Lost(ErError):
    """The executor is gone with what it had to do; nobody goes on."""


class OtherCode(ErError):
    """A worker has other versions than who asks."""


@dataclass(frozen=True)
class Engine:
    """Who does the jobs.

    workers: how many do them at once; again: gives another executor after one was lost, or raises `Lost`; died: whether
    an error says that a worker died with its job, which is then tried alone; count: how many workers there are by now.
    """

    executor: Executor
    workers: int
    again: Callable[[], Executor] | None = None
    died: Callable[[BaseException], bool] = lambda _: False
    count: Callable[[], int] | None = None


@dataclass
class _Run:
    """What is under way: batches by their future, batches to hand out again, and how long a job takes [s]."""

    engine: Engine
    running: dict[Future[Any], Sequence[Job]] = field(default_factory=dict)
    back: list[Sequence[Job]] = field(default_factory=list)
    done: SimpleQueue[Future[Any]] = field(default_factory=SimpleQueue)
    each: float = 0.0
    counted: float = 0.0

    def recount(self) -> None:
        """Count the workers, where that was not done lately."""
        engine, now = self.engine, time.monotonic()
        if engine.count is not None and now - self.counted > COUNT:
            self.counted = now
            with suppress(Exception):  # whatever a library says when its other end is gone
                self.engine = replace(engine, workers=max(1, engine.count()))


def spread(
    engine: Engine, function: Callable[[Any, Asked], Any], jobs: Iterator[Job], asked: Asked, told: Told,
    check: Callable[[], None],
) -> Engine:  # fmt: skip
    """Have all jobs done; told of each in the caller's thread, in any order. The engine that is left.

    check: raises where the work shall stop; what is handed out is then taken back.

    Raises:
        OtherCode: A worker has other versions.
        Lost: Whoever did the work is gone.
    """
    run, sealed, left = _Run(engine), seal(function, asked), True
    try:
        while left or run.running or run.back:
            check()
            run.recount()
            left = _fill(run, jobs, sealed, left=left)
            for future in _ended(run.done):
                _take(run, future, told)
    finally:
        for future in run.running:
            future.cancel()
    return run.engine


def _fill(run: _Run, jobs: Iterator[Job], sealed: bytes, *, left: bool) -> bool:
    """Hand out as many batches as there is room for; whether jobs are left."""
    while len(run.running) < AHEAD * run.engine.workers and (left or run.back):
        batch = (
            run.back.pop()
            if run.back
            else list(islice(jobs, batch_size(run.each, run.engine.workers)))
        )
        if not batch:
            return False
        try:
            future = run.engine.executor.submit(pickle.loads, later(work, batch, sealed))
        except Exception:  # whatever a library says when its other end is gone
            run.back.append(batch)
            _another(run)
            continue
        run.running[future] = batch
        future.add_done_callback(run.done.put)
    return left


def batch_size(each: float, workers: int) -> int:
    """How many jobs of so many seconds make a batch; one while nothing is known of them."""
    return max(1, min(LARGEST, int(max(SECONDS, EACH * workers) / each))) if each > 0.0 else 1


def _ended(done: SimpleQueue[Future[Any]]) -> list[Future[Any]]:
    """Futures that have ended; waits a little for the first."""
    found: list[Future[Any]] = []
    with suppress(Empty):
        found.append(done.get(timeout=LOOK))
        while True:
            found.append(done.get_nowait())
    return found


def _take(run: _Run, future: Future[Any], told: Told) -> None:
    """Tell of a batch that has ended, or hand it out again."""
    batch = run.running.pop(future, None)
    if batch is None:
        return
    error = CancelledError() if future.cancelled() else future.exception()
    if error is None:
        results, seconds = future.result()
        mean = seconds / len(batch)
        run.each = mean if run.each == 0.0 else 0.7 * run.each + 0.3 * mean
        for (number, _), result in zip(batch, results, strict=True):
            told(number, result)
    elif isinstance(error, OtherCode):
        raise error
    elif isinstance(error, ImportError):  # no job: the worker cannot even begin
        raise OtherCode(other_sources(error))
    elif isinstance(error, CancelledError | Lost):
        run.back.append(batch)
        _another(run)
    elif run.engine.died(error) and len(batch) > 1:
        run.back += [[job] for job in batch]
    else:
        for number, _ in batch:
            told(number, Failure(f"{type(error).__name__}: {error}".splitlines()[0][:300]))


def _another(run: _Run) -> None:
    """Go on with another executor, and all that the old one had."""
    if run.engine.again is None:
        raise Lost("the workers are gone")
    lost, run.running = run.running, {}
    run.back += lost.values()
    for future in lost:
        future.cancel()
    run.engine = replace(run.engine, executor=run.engine.again())


class _Later:
    """A call that is made where it is unpickled."""

    def __init__(self, function: Callable[..., Any], *args: Any) -> None:
        """The function, to be called with these arguments."""
        self._call = function, args

    def __reduce__(self) -> tuple[Any, ...]:
        return self._call


def later(function: Callable[..., Any], *args: Any) -> bytes:
    """A call for `pickle.loads` of a worker: one that has no sources of ours says so, where Dask's worker would die."""
    return pickle.dumps(_Later(function, *args))


def seal(function: Callable[[Any, Asked], Any], asked: Asked) -> bytes:
    """What is done and asked, for workers: the versions outside, so that they are compared before the rest is read."""
    return pickle.dumps((code(), pickle.dumps((function, asked))))


def work(batch: Sequence[Job], sealed: bytes) -> tuple[list[Any], float]:
    """What a worker does: the results of a batch, and how long it took [s]; a job that fails is a `Failure`.

    Raises:
        OtherCode: The code here is another than that of who asks.
    """
    begun = time.perf_counter()
    wanted, inner = pickle.loads(sealed)
    differ = unlike(wanted, code())
    if differ:
        raise OtherCode(differ)
    function, asked = pickle.loads(inner)
    return [_done(function, job, asked) for _, job in batch], time.perf_counter() - begun


def other_sources(error: ImportError) -> str:
    """A worker that cannot import what it shall do, in one line."""
    return f"a worker cannot begin ({' '.join(str(error).split())}): install there what is here"


def unlike(wanted: dict[str, str], found: dict[str, str], where: str = "a worker") -> str:
    """What differs between the code of who asks and that of a worker, in one line; empty where nothing does."""
    pairs = [
        f"{name} {found.get(name, 'not installed')} instead of {version}"
        for name, version in wanted.items() if found.get(name) != version
    ]  # fmt: skip
    return f"{where} has {', '.join(pairs)}: install there what is here" if pairs else ""


def _done(function: Callable[[Any, Asked], Any], job: Any, asked: Asked) -> Any:
    """A job done in this thread and no other."""
    try:
        return on_one_thread(Call(function, (asked,)))(job)
    except ErError as error:
        lasting = not isinstance(error, Unreachable)
        return Failure(" ".join(str(error).split()), kept=lasting)
    except Exception as error:  # one recording ends no fleet
        return Failure(f"{type(error).__name__}: {error}".splitlines()[0][:300])
