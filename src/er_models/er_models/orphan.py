"""No process is left behind by one that was killed, and none takes from the loop what it needs."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from contextlib import suppress

_PR_SET_PDEATHSIG = 1
NICE = 19
"""Of a process beside the loop: it has what the loop leaves."""
_LIBC = ctypes.CDLL(None, use_errno=True) if sys.platform == "linux" else None


def end_with_parent() -> None:
    """Called in a child: the kernel sends it SIGTERM when its parent ends, however that ends; Linux only."""
    if _LIBC is not None:
        _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)


def step_aside() -> None:
    """Called in a process that works beside the loop: the loop's priority, which it was born with, is not for it."""
    with suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    os.nice(NICE)


def wait_for_owner() -> None:
    """Return when whoever holds the other end of standard input closes it, or is gone; for a thread.

    Read without a buffer: its lock would be held when the process ends, and abort it.
    """
    while os.read(0, 1024):
        pass
