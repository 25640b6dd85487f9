"""Who does the work of a search, who is told of it, and who may stop it. No other file hands out jobs.

A job is a function of a module with arguments that can be pickled; so threads, processes and clusters give the same
results to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from typing import Any, Protocol, TypeVar

from er_models.parallel import threads

from er_model_lab.jobs.call import Call, inside_a_job
from er_model_lab.jobs.handing_out import beside, by, here
from er_model_lab.jobs.processes import PROCESSES, Processes

Job = TypeVar("Job")
Result = TypeVar("Result")

WORTH = 30.0
"""Work [s] from which other processes are started for it: below, threads are as fast, and there at once."""


class Cancelled(Exception):
    """The work was cancelled before there was anything to keep."""


STOPPED = (KeyboardInterrupt, Cancelled)
"""How work ends on request: Ctrl-C, or the event that was given as `cancel`."""


@dataclass(frozen=True)
class Leader:
    """A candidate that is ahead so far.

    rmse: its error [N], cross-validated where it was judged; evidence: by how much it lowers that of the model without
    it [N].
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

    executor: does the jobs; None: the caller's thread, one after the other; `PROCESSES`: processes of this machine
    beside the caller's thread. progress: called in the caller's thread, whenever a job is done. cancel: once it is
    set, work ends as after Ctrl-C.
    """

    executor: Executor | None = None
    progress: Progress | None = None
    cancel: Event | None = None
    _state: _State = field(default_factory=_State, init=False, repr=False, compare=False)

    @classmethod
    def by(
        cls, executor: Executor | None, progress: Progress | None, cancel: Event | None
    ) -> Work:
        """Work as a user asks for it: by the lab's own processes where no executor is given."""
        return cls(executor or PROCESSES, progress, cancel)

    def reporting(self, progress: Progress) -> Work:
        """The same work with another listener."""
        made = replace(self, progress=progress)
        object.__setattr__(made, "_state", self._state)
        return made

    def expect(self, seconds: float, function: Callable[..., Any], *args: Any) -> None:
        """Say that jobs of so many seconds of one core will come, so that processes are there in time.

        function: what each of them calls first, to have ready what jobs need.
        """
        if isinstance(self.executor, Processes) and seconds > WORTH:
            self.executor.start(function, *args)

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
        """Tell how far a stage is; best: who is ahead, None: the same as before. A job tells nothing of its own."""
        self.check()
        if inside_a_job():
            return
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

        call = Call(function, shared)
        if self.executor is None or self._state.winding_up or len(jobs) < 2 or inside_a_job():
            here(call, jobs, told, self.check)
        elif isinstance(self.executor, Processes) and not self.executor.room:
            by(threads(), call, jobs, told, self.check)
        elif isinstance(self.executor, Processes):
            beside(self.executor, call, jobs, told, self.check)
        else:
            by(self.executor, call, jobs, told, self.check)
        return [found[k] for k in range(len(jobs))]


HERE = Work()
"""One job after the other in the caller's thread, silent and to the end."""
