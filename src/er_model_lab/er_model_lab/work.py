"""Who does the work of a search, who is told of it, and who may stop it. No other file hands out jobs.

A job is a function of a module with arguments that can be pickled; so threads, processes and clusters give the same
results to the last bit.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeVar

from er_model_lab.parcel import Parcel, packed

Job = TypeVar("Job")
Result = TypeVar("Result")

LOOK = 0.1
"""How often a stage that waits for others looks whether it shall stop [s]."""


class Cancelled(Exception):
    """The work was cancelled before there was anything to keep."""


STOPPED = (KeyboardInterrupt, Cancelled)
"""How work ends on request: Ctrl-C, or the event that was given as `cancel`."""


@dataclass(frozen=True)
class Leader:
    """A candidate that is ahead so far.

    rmse: its cross-validated error [N]; evidence: by how much it lowers that of the model without it [N].
    """

    effect: str
    rmse: float
    evidence: float


Progress = Callable[[str, int, int, tuple[Leader, ...]], None]
"""Told the stage, how many of its jobs are done, how many there are, and which candidates are ahead, best first."""


class Event(Protocol):
    """What `threading.Event` and its like have in common."""

    def is_set(self) -> bool:
        """Whether the work shall stop."""


@dataclass
class _State:
    """What changes while work is done."""

    ahead: tuple[Leader, ...] = ()
    winding_up: bool = False


@dataclass(frozen=True)
class Work:
    """How work is done.

    executor: does the jobs; None: the caller's thread, one after the other. progress: called in the caller's thread,
    whenever a job is done. cancel: once it is set, work ends as after Ctrl-C.
    """

    executor: Executor | None = None
    progress: Progress | None = None
    cancel: Event | None = None
    _state: _State = field(default_factory=_State, init=False, repr=False, compare=False)

    def check(self) -> None:
        """Raise `Cancelled` where the work shall stop; what takes long asks every now and then."""
        if self.cancel is not None and self.cancel.is_set() and not self._state.winding_up:
            raise Cancelled

    def wind_up(self) -> None:
        """After `STOPPED`: what still makes a result of what was done is neither stopped nor handed out."""
        self._state.winding_up = True

    def report(
        self, stage: str, done: int, total: int, best: Sequence[Leader] | None = None
    ) -> None:
        """Tell how far a stage is; best: who is ahead, None: the same as before."""
        self.check()
        if best is not None:
            self._state.ahead = tuple(best)
        if self.progress is not None:
            self.progress(stage, done, total, self._state.ahead)

    def map(
        self,
        function: Callable[..., Result],
        jobs: Sequence[Job],
        *shared: Any,
        stage: str = "",
        best: Callable[[list[Result]], Sequence[Leader] | None] | None = None,
    ) -> list[Result]:
        """Results of function(job, *shared), in the order of the jobs; after an error no job is begun.

        What is shared is sent to each process once. stage: what is reported, if anything; best: called with what is
        done so far, in any order, whenever another job is done.
        """
        found: dict[int, Result] = {}

        def told(k: int, result: Result) -> None:
            found[k] = result
            ahead = best(list(found.values())) if best else None
            if stage:
                self.report(stage, len(found), len(jobs), ahead)

        call = self._call(function, shared) if len(jobs) > 1 else None
        if call is None:
            for k, job in enumerate(jobs):
                self.check()
                told(k, function(job, *shared))
        else:
            self._handed_out(call, jobs, told)
        return [found[k] for k in range(len(jobs))]

    def _call(self, function: Callable[..., Result], shared: tuple[Any, ...]) -> _Call | None:
        """What the executor is asked to do with each job; None where there is none, or it cannot be sent there."""
        if self.executor is None or self._state.winding_up or _inside.job:
            return None
        if isinstance(self.executor, ThreadPoolExecutor):
            return _Call(function, Parcel(shared))
        parcel = packed(shared)
        return None if parcel is None else _Call(function, parcel)

    def _handed_out(
        self, call: _Call, jobs: Sequence[Job], told: Callable[[int, Result], None]
    ) -> None:
        """Have the executor do all jobs."""
        assert self.executor is not None
        running: dict[Future[Result], int] = {}
        try:
            for k, job in enumerate(jobs):
                running[self.executor.submit(call, job)] = k
            while running:
                self.check()
                for future in wait(running, LOOK, FIRST_COMPLETED).done:
                    told(running.pop(future), future.result())
        finally:
            for future in running:
                future.cancel()


HERE = Work()
"""One job after the other in the caller's thread, silent and to the end."""


class _Inside(threading.local):
    """Whether this thread does a job: what that hands out it does itself, since all others may wait as it would."""

    job = False


_inside = _Inside()


@dataclass(frozen=True)
class _Call:
    """A function with what all its jobs share."""

    function: Callable[..., Any]
    shared: Parcel

    def __call__(self, job: Any) -> Any:
        _inside.job = True
        try:
            return self.function(job, *self.shared.content)
        finally:
            _inside.job = False
