"""Work spread over processes, each with one thread, so that two cores do two cases."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import TypeVar

from er_models.orphan import end_with_parent

J = TypeVar("J")
R = TypeVar("R")
ONE_THREAD = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")


def spread(work: Callable[[J], R], jobs: Sequence[J], workers: int) -> Iterator[R]:
    """Results in the order they are done; with one worker in this process.

    ``work`` must be a function of a module. Workers start anew, since the number of threads is read once.
    """
    if workers == 1:
        yield from map(work, jobs)
        return
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    try:
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(workers, context, end_with_parent) as pool:
            futures = [pool.submit(work, job) for job in jobs]
            try:
                for done in as_completed(futures):
                    yield done.result()
            finally:
                pool.shutdown(wait=False, cancel_futures=True)
    finally:
        for name, value in before.items():
            os.environ.pop(name) if value is None else os.environ.__setitem__(name, value)
