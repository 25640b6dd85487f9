"""Work that is spread over the cores: threads, since the compiled kernel holds no lock of Python."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from itertools import pairwise
from typing import TypeVar

Job = TypeVar("Job")
Result = TypeVar("Result")

PIECES = 4
"""Pieces a core gets: more even out what else the machine does, fewer cost less."""
WORTH = 200_000
"""Steps of the integrator, some 3 ms, from which a second core pays for waking it."""


def cores() -> int:
    """Cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@lru_cache(maxsize=1)
def _pool() -> ThreadPoolExecutor:
    """The threads of this process, made once: one for every core, since the one that asks may have to wait."""
    return ThreadPoolExecutor(cores(), "er_models")


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pool.cache_clear)  # threads do not survive a fork


def over_cores(run: Callable[[int, int], None], n: int, steps: int) -> None:
    """Call run(i, j) for pieces i:j of n equal jobs that take so many steps of the integrator together."""
    pieces = min(n, PIECES * cores()) if steps > WORTH and cores() > 1 else min(n, 1)
    edges = [n * k // pieces for k in range(pieces + 1)] if pieces else []
    _shared(lambda piece: run(*piece), list(pairwise(edges)))


def in_turn(
    run: Callable[[Job], Result], jobs: Sequence[Job], told: Callable[[Job], None] | None = None
) -> list[Result]:
    """Results of unequal jobs that take some tenths of a second each, in their order.

    Every core has a job of its own; what a job spreads over the cores is taken by those that have none left.
    told: called in this thread for every job that is done, in their order. After an error or Ctrl-C no job is begun.
    """
    found: dict[int, Result] = {}
    untold = deque(range(len(jobs) if told else 0))

    def tell() -> None:
        while told and untold and untold[0] in found:
            told(jobs[untold.popleft()])

    def one(k: int) -> None:
        found[k] = run(jobs[k])

    _shared(one, range(len(jobs)), tell)
    return [found[k] for k in range(len(jobs))]


def _shared(
    run: Callable[[Job], None], jobs: Iterable[Job], between: Callable[[], None] = lambda: None
) -> None:
    """Do all jobs, in this thread and in those of the pool that have nothing else to do.

    A thread never waits for a job that nobody has begun, so that jobs may share work of their own. between: called
    in this thread after each of its jobs, and at the end.
    """
    left = deque(jobs)

    def work(between: Callable[[], None] = lambda: None) -> None:
        try:
            while True:
                try:
                    job = left.popleft()
                except IndexError:
                    return
                run(job)
                between()
        finally:
            left.clear()  # it is empty already, but for an error: no further job is begun

    helpers = [_pool().submit(work) for _ in range(min(cores(), len(left)) - 1)]
    try:
        work(between)
    finally:
        begun = [helper for helper in helpers if not helper.cancel()]
    for helper in begun:
        helper.result()
    between()
