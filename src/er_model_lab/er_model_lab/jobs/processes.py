"""The lab's own processes: started while data are read, kept for the next call, ended with their owner."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import shutil
import signal
import sys
import tempfile
import threading
import time
import warnings
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, Future
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

from er_models.parallel import cores

Result = TypeVar("Result")

THREADS = {
    "NUMBA_NUM_THREADS": "2", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1",
}  # fmt: skip
"""Environment of a process: linear algebra on one thread, predictions on a second core where that has nothing to do."""
IDLE = 300.0
"""Time after which a process that nobody asks ends [s]."""
READY = "ready_"
"""What the file of a process that has begun is called, before its number."""
UNSENT = (pickle.PicklingError, TypeError, AttributeError)
"""Raised where something cannot be sent to another process."""
LOOK = 0.5
"""How often a process looks whether its owner is still there [s]."""


class Processes(Executor):
    """One process fewer than the cores that this one may use: it does jobs itself."""

    def __init__(self) -> None:
        self._pool: Any = None
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self._asked, self._number = 0.0, 0
        self._lock = threading.Lock()

    @property
    def folder(self) -> Path | None:
        """Where to put what jobs share, for nobody else to read; None where they were not started."""
        return Path(self._folder.name) if self._folder else None

    @property
    def ready(self) -> set[int]:
        """Processes that have begun; none where another thread has just ended them."""
        try:
            names = os.listdir(self.folder) if self.folder else []
        except FileNotFoundError:
            return set()
        return {int(name[len(READY) :]) for name in names if name.startswith(READY)}

    @property
    def room(self) -> int:
        """Jobs that may wait there: for each process that is ready one, and another so that it need not wait.

        One that grew ends, and another takes its place: both have begun.
        """
        return 2 * min(len(self.ready), self._number)

    def start(self, function: Callable[..., Any], *args: Any) -> None:
        """Begin to start them where they are not there yet; each calls the function first.

        A process that was itself started to share work starts none: others have the remaining cores.
        """
        number, now = cores() - 1, time.monotonic()
        if number < 1 or multiprocessing.parent_process() is not None:
            return
        with self._lock, suppress(*UNSENT):
            gone, self._asked = now - self._asked > IDLE, now
            if self._pool is None:
                self._number = number
                self._pool = self._made(number, pickle.dumps((function, args)))
            elif not gone:
                return
            for pid in self.ready:
                Path(self.folder or "", f"{READY}{pid}").unlink(missing_ok=True)
            self._pool.submit(os.getpid)  # which starts those that are not there

    def _made(self, number: int, first: bytes) -> Any:
        """So many processes; they do not run the caller's script again, which need not guard itself against that."""
        from joblib.externals.loky import ProcessPoolExecutor

        warnings.filterwarnings("ignore", "Failed to kill subprocesses")  # it means their own
        warnings.filterwarnings("ignore", "A worker stopped")  # one that grew is made anew
        self._folder = tempfile.TemporaryDirectory(prefix="er_lab_")
        begin = (os.getpid(), self._folder.name, first)
        # it frees what processes that were ended at once have left, and need not say so
        sys.warnoptions.append("ignore:resource_tracker")
        try:
            return ProcessPoolExecutor(
                number, timeout=IDLE, initializer=_begin, initargs=begin, env=THREADS
            )
        finally:
            sys.warnoptions.pop()

    def submit(self, fn: Callable[..., Result], /, *args: Any, **options: Any) -> Future[Result]:
        """Have one of them do a job; `BrokenExecutor` where there are none, or one of them died."""
        pool, self._asked = self._pool, time.monotonic()
        try:
            if pool is None:
                raise BrokenExecutor("no processes")
            found: Future[Result] = pool.submit(fn, *args, **options)
        except RuntimeError as error:
            if pool is self._pool:
                self.shutdown()
            raise BrokenExecutor(str(error)) from error
        return found

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = True) -> None:
        """End them, whatever they do; `start` makes new ones."""
        del wait, cancel_futures
        with self._lock:
            pool, folder, pids = self._pool, self._folder, self.ready
            self._pool, self._folder = None, None
        for child in multiprocessing.active_children():
            if child.pid in pids:
                os.kill(child.pid, signal.SIGKILL)
        if pool is not None:
            pool.shutdown(wait=False)
        if folder is not None:
            folder.cleanup()


def lost(error: BaseException | None) -> bool:
    """Whether a job did not fail but was not done: its process died, or all of them were ended."""
    return isinstance(error, BrokenExecutor) or type(error).__name__ == "ShutdownExecutorError"


def _begin(owner: int, folder: str, first: bytes) -> None:
    """What a process does first: Ctrl-C is for its owner, and it ends when that does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(owner, folder), daemon=True).start()
    with suppress(Exception):  # a job that needs it will tell
        function, args = pickle.loads(first)
        function(*args)
    Path(folder, f"{READY}{os.getpid()}").touch()


def _end_with(owner: int, folder: str) -> None:
    """End this process once its owner is gone.

    The kernel could tell, but of the thread that started the process, which may end long before.
    """
    while os.getppid() == owner:
        time.sleep(LOOK)
    shutil.rmtree(folder, ignore_errors=True)
    os._exit(1)


PROCESSES = Processes()
"""Those of this process."""
