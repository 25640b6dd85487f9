"""Work that is spread over the cores: threads, since the compiled kernel holds no lock of Python."""

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


def cores() -> int:
    """Cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@lru_cache(maxsize=1)
def _pool() -> ThreadPoolExecutor:
    """The threads of this process, made once."""
    return ThreadPoolExecutor(cores(), "er_models")


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pool.cache_clear)  # threads do not survive a fork


def over_cores(run: Callable[[int, int], None], n: int, steps: int) -> None:
    """Call run(i, j) for pieces i:j of n equal jobs that take so many steps of the integrator together."""
    pieces = min(n, PIECES * cores()) if steps > WORTH and cores() > 1 else min(n, 1)
    edges = [n * k // pieces for k in range(pieces + 1)] if pieces else []
    jobs = list(pairwise(edges))
    if len(jobs) < 2:
        for i, j in jobs:
            run(i, j)
        return
    for job in [_pool().submit(run, i, j) for i, j in jobs]:
        job.result()
