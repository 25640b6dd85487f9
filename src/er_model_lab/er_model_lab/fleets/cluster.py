"""Dask as who does the work of a fleet: processes of this machine, or a cluster by its address.

A worker unpickles what a scheduler sends it, and so does who asks: an address is to be trusted like a program. Over a
network use `tls://` with the certificates of Dask's configuration (distributed.comm.tls) or a `Security`.
"""

from __future__ import annotations

import logging
import pickle
import time
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager, suppress
from tempfile import TemporaryDirectory
from typing import Any

from er_common.extras import extra
from er_common.port import HOST
from er_models.errors import InputError
from er_models.parallel import cores

from er_model_lab.fleets.asked import code
from er_model_lab.fleets.engine import Engine, Lost, OtherCode, later, other_sources, unlike
from er_model_lab.jobs.processes import THREADS

PATIENCE = 60.0
"""How long a scheduler that is gone is waited for [s]."""
ONE = {**THREADS, "NUMBA_NUM_THREADS": "1"}
"""Environment of a worker: one of them has one core."""
LOCAL = {
    "distributed.worker.daemon": True, "distributed.comm.timeouts.connect": "60s",
    "distributed.worker.profile.enabled": False, "distributed.admin.tick.interval": "500ms",
    "distributed.admin.system-monitor.interval": "2s", "distributed.worker.memory.monitor-interval": "500ms",
}  # fmt: skip
"""Dask's configuration of workers of this machine. Its profiler, which nobody looks at here, takes a tenth of one; that
every event loop looks at its own lateness fifty times a second, and at memory ten times, as much again.
"""
WORKER = "er_model_lab.fleets.worker"
"""Module whose `dask_setup` a worker calls first."""


@contextmanager
def cluster(
    address: str | None, *, workers: int | None = None, security: Any = None
) -> Iterator[Engine]:
    """Dask's workers: those of an address, else processes of this machine, one for each core.

    security: `distributed.Security` for a `tls://` address; else what Dask's configuration says.

    Raises:
        ErError: Dask is not installed.
        InputError: Nobody answers there.
        OtherCode: Workers have other versions.
    """
    with extra("er_model_lab[fleet]", "a fleet"):
        import distributed
    if address is None:
        with (
            TemporaryDirectory(prefix="er_fleet_") as folder,
            _here(distributed, workers, folder) as here,
            _served(distributed, here, None) as engine,
        ):
            yield engine
        return
    with _served(distributed, address, security) as engine:
        yield engine


@contextmanager
def _here(distributed: Any, workers: int | None, folder: str) -> Iterator[Any]:
    """The address of processes of this machine."""
    import dask

    with (
        dask.config.set(LOCAL),
        distributed.LocalCluster(
            n_workers=workers or cores(), threads_per_worker=1, processes=True, dashboard_address=None,
            host=HOST, local_directory=folder, silence_logs=logging.CRITICAL, env=ONE,
            preload=[WORKER],
        ) as made,
    ):  # fmt: skip
        yield made.scheduler_address


def _client(distributed: Any, address: str, security: Any, patience: float = 30.0) -> Any:
    """A client of the scheduler at an address, with one worker at least."""
    try:
        client = distributed.Client(
            address, security=security, timeout=patience, set_as_default=False
        )
    except (OSError, ValueError, TypeError, RuntimeError) as error:
        said = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(address, "--cluster", "the address of a Dask scheduler", said) from None
    try:
        client.wait_for_workers(1, timeout=patience)
    except TimeoutError:
        _closed(client)
        raise InputError(address, "--cluster", "at least one worker", "none") from None
    return client


def refuse_others(client: Any) -> None:
    """Refuse workers whose code or packages differ, by name."""
    try:
        every = client.run(pickle.loads, later(code))
    except ImportError as error:
        raise OtherCode(other_sources(error)) from None
    for worker, found in every.items():
        if differ := unlike(code(), found, f"worker {worker}"):
            raise OtherCode(differ)


@contextmanager
def _served(distributed: Any, address: str, security: Any) -> Iterator[Engine]:
    """The engine of the workers at an address, which finds its scheduler again."""
    kept = [_client(distributed, address, security)]

    def again() -> Executor:
        """Another client, once the scheduler is there again."""
        end = time.monotonic() + PATIENCE
        _closed(kept[0])
        while True:
            try:
                kept[0] = _client(distributed, address, security)
                return _executor(kept[0])
            except InputError as error:
                if time.monotonic() > end:
                    raise Lost(f"the scheduler is gone: {error}") from None

    def count() -> int:
        """Workers that there are now."""
        return sum(kept[0].nthreads().values())

    try:
        refuse_others(kept[0])
        yield Engine(_executor(kept[0]), count() or 1, again, _died, count)
    finally:
        _closed(kept[0])


def _executor(client: Any) -> Executor:
    """The client as an executor."""
    found: Executor = client.get_executor(pure=False)
    return found


def _died(error: BaseException) -> bool:
    """Whether Dask gave up a job whose workers died."""
    return type(error).__name__ == "KilledWorker"


def _closed(client: Any) -> None:
    """Close a client, whatever is left of its scheduler."""
    with suppress(Exception):
        client.close(timeout=2)
