"""Jobs of a stage handed out: to an executor that was given, or to the lab's own processes and this one."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import Any

from er_model_lab.jobs.call import Call, packed
from er_model_lab.jobs.processes import Processes, lost

LOOK = 0.1
"""How often a stage that waits for others looks whether it shall stop [s]."""

Told = Callable[[int, Any], None]
"""Called with the place of each job that is done, and its result."""


class _Done:
    """Futures in the order in which they end.

    `concurrent.futures.wait` holds their locks one after the other: Ctrl-C in between leaves them held, and every
    thread that has a result waits for ever.
    """

    def __init__(self) -> None:
        self._queue: SimpleQueue[Future[Any]] = SimpleQueue()

    def told_of(self, future: Future[Any]) -> Future[Any]:
        """The same future, which comes to `wait` once it has ended."""
        future.add_done_callback(self._queue.put)
        return future

    def wait(self, seconds: float) -> list[Future[Any]]:
        """Those that have ended since; waits so long for the first [s]."""
        found = []
        with suppress(Empty):
            found.append(self._queue.get(timeout=seconds) if seconds else self._queue.get_nowait())
            while True:
                found.append(self._queue.get_nowait())
        return found


def here(call: Call, jobs: Sequence[Any], told: Told, check: Callable[[], None]) -> None:
    """Do all jobs in this thread, one after the other; check: raises where the work shall stop."""
    for k, job in enumerate(jobs):
        check()
        told(k, call.function(job, *(call.content or ())))


def by(
    executor: Executor, call: Call, jobs: Sequence[Any], told: Told, check: Callable[[], None]
) -> None:
    """Have an executor do all jobs; here, where they cannot be sent to it."""
    sent = call if isinstance(executor, ThreadPoolExecutor) else packed(call)
    if sent is None:
        return here(call, jobs, told, check)
    running, done = dict[Future[Any], int](), _Done()
    try:
        for k, job in enumerate(jobs):
            running[done.told_of(executor.submit(sent, job))] = k
        while running:
            check()
            for future in done.wait(LOOK):
                told(running.pop(future), future.result())
    finally:
        for future in running:
            future.cancel()
    return None


def beside(
    own: Processes, call: Call, jobs: Sequence[Any], told: Told, check: Callable[[], None]
) -> None:
    """Do jobs here while the lab's own processes, as they become ready, do others."""
    left, running, done = deque(range(len(jobs))), dict[Future[Any], int](), _Done()
    sent, able = None, True
    try:
        while left or running:
            check()
            if able and sent is None and left and own.room:
                sent = packed(call, own.folder)
                able = sent is not None
            if sent is not None:
                _submitted(own, sent, jobs, left, running, done)
            mine = left.popleft() if left else None
            if mine is not None:
                told(mine, call(jobs[mine]))
            for future in done.wait(LOOK if mine is None else 0.0):
                k = running.pop(future)
                if lost(future.exception()):
                    left.append(k)
                    sent = None  # it went with them
                else:
                    told(k, future.result())
    finally:
        if running:
            own.shutdown()
        if sent is not None:
            sent.discard()


def _submitted(
    own: Processes, call: Call, jobs: Sequence[Any], left: deque[int], running: dict[Future[Any], int], done: _Done
) -> None:  # fmt: skip
    """Hand out as many jobs as there is room for."""
    while left and len(running) < own.room:
        k = left.popleft()
        try:
            running[done.told_of(own.submit(call, jobs[k]))] = k
        except BrokenExecutor:
            left.appendleft(k)
