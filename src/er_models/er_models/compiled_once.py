"""Compiled functions on disk, where each is compiled by one process: others that want it wait, and read it.

A graph starts six processes at once, three of them observers that run the same functions. Each compiled all of them,
and a first start on two cores took half as long again.
"""

from __future__ import annotations

import fcntl
import os
import time
from collections.abc import Callable
from typing import Any

import numba

PATIENCE, LOOK = 120.0, 0.02
"""Longest wait for another process, which may be stopped, and how often it is asked whether it is ready [s]."""


class Once:
    """A cache of Numba's for one function, with a lock from where it has nothing until something is put in."""

    def __init__(self, cache: Any) -> None:
        self._cache = cache
        self._lock: int | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._cache, name)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """What is compiled for a signature; None: compile it, nobody else does meanwhile."""
        found = self._cache.load_overload(sig, target_context)
        if found is None and self._lock is None:
            self._lock = _locked(os.path.join(self._cache.cache_path, f"{self._name}.lock"))
            found = self._cache.load_overload(sig, target_context)
            if found is not None:
                self._let_go()
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Put it in, for all who wait."""
        try:
            self._cache.save_overload(sig, data)
        finally:
            self._let_go()

    @property
    def _name(self) -> str:
        return str(self._cache._impl.filename_base)

    def _let_go(self) -> None:
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None


def _locked(path: str) -> int | None:
    """A file that is locked, which the end of the process unlocks; None where there is none, or after `PATIENCE`."""
    try:
        os.makedirs(os.path.dirname(path), exist_ok=True)
        file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
    except OSError:
        return None
    end = time.monotonic() + PATIENCE
    while True:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() < end:
                time.sleep(LOOK)
                continue
        except OSError:
            pass
        else:
            return file
        os.close(file)
        return None


def on_disk(**options: Any) -> Callable[[Any], Any]:
    """A decorator as `numba.njit` with ``cache=True`` and these options.

    It raises what `numba.njit` raises where no folder can be written to.
    """

    def decorate(function: Any) -> Any:
        dispatcher: Any = numba.njit(cache=True, **options)(function)
        dispatcher._cache = Once(dispatcher._cache)
        return dispatcher

    return decorate
