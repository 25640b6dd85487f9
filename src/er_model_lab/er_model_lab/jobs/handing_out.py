"""Jobs of a stage handed out: to an executor that was given, or to the lab's own processes and this one."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    Executor,
    Future,
    ThreadPoolExecutor,
    wait,
)
from typing import Any

from er_model_lab.jobs.call import Call, packed
from er_model_lab.jobs.processes import Processes, lost

LOOK = 0.1
"""How often a stage that waits for others looks whether it shall stop [s]."""

Told = Callable[[int, Any], None]
"""Called with the place of each job that is done, and its result."""


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
    running: dict[Future[Any], int] = {}
    try:
        for k, job in enumerate(jobs):
            running[executor.submit(sent, job)] = k
        while running:
            check()
            for future in wait(running, LOOK, FIRST_COMPLETED).done:
                told(running.pop(future), future.result())
    finally:
        for future in running:
            future.cancel()
    return None


def beside(
    own: Processes, call: Call, jobs: Sequence[Any], told: Told, check: Callable[[], None]
) -> None:
    """Do jobs here while the lab's own processes, as they become ready, do others."""
    left, running = deque(range(len(jobs))), dict[Future[Any], int]()
    sent, able = None, True
    try:
        while left or running:
            check()
            if able and sent is None and left and own.room:
                sent = packed(call, own.folder)
                able = sent is not None
            if sent is not None:
                _submitted(own, sent, jobs, left, running)
            mine = left.popleft() if left else None
            if mine is not None:
                told(mine, call(jobs[mine]))
            for future in wait(running, LOOK if mine is None else 0.0, FIRST_COMPLETED).done:
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
    own: Processes, call: Call, jobs: Sequence[Any], left: deque[int], running: dict[Future[Any], int]
) -> None:  # fmt: skip
    """Hand out as many jobs as there is room for."""
    while left and len(running) < own.room:
        k = left.popleft()
        try:
            running[own.submit(call, jobs[k])] = k
        except BrokenExecutor:
            left.appendleft(k)
