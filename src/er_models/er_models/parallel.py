"""Predictions of one process on all its cores: threads, since the compiled kernel holds no lock of Python."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from itertools import pairwise

PIECES = 4
"""Pieces a core gets: more even out what else the machine does, fewer cost less."""
WORTH = 200_000
"""Steps of the integrator, some 3 ms, from which a second core pays for waking it."""
LONGEST = 2 * WORTH
"""Steps of a piece of several jobs, at most: what stands in series takes fifty times as long, and Ctrl-C waits for it.
"""


def cores() -> int:
    """Cores this process may use; NUMBA_NUM_THREADS=1 says that others have the rest of the machine."""
    able = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    limit = os.environ.get("NUMBA_NUM_THREADS", "")
    return max(min(able or 1, int(limit) if limit.isdigit() else able or 1), 1)


@lru_cache(maxsize=1)
def threads() -> ThreadPoolExecutor:
    """The threads of this process, made once: one for every core, since the one that asks may have to wait."""
    return ThreadPoolExecutor(cores(), "er_models")


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=threads.cache_clear)  # threads do not survive a fork


def over_cores(run: Callable[[int, int], None], n: int, steps: int) -> None:
    """Call run(i, j) for pieces i:j of n equal jobs that take so many steps of the integrator together.

    This thread takes back, from the last on, what no other has begun: it never waits for that, and jobs may share
    work of their own. After an error or Ctrl-C in this thread no piece is begun.
    """
    if not n:
        return
    alone = steps <= WORTH or cores() < 2 or n < 2
    pieces = min(n, max(1 if alone else PIECES * cores(), -(-steps // LONGEST)))
    parts = list(pairwise(n * k // pieces for k in range(pieces + 1)))
    if alone:
        for part in parts:
            run(*part)
        return
    futures = [threads().submit(run, *part) for part in parts]
    try:
        for future, part in zip(reversed(futures), reversed(parts), strict=True):
            if future.cancel():
                run(*part)
        for future in futures:
            if not future.cancelled():
                future.result()
    finally:
        for future in futures:
            future.cancel()
