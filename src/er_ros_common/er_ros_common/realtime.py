"""Real-time priority (SCHED_FIFO) of this process, while its nodes act: what is busy beside them then waits.

All threads get it, those of the middleware too, which take messages off the wire; threads made later inherit it. Nodes
that share a process share the highest one asked for. Configuring may compile for many seconds: it is done without,
also where another node of the process acts already, which waits for its end anyhow.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

THREADS = Path("/proc/self/task")
_asked: dict[str, int] = {}


def ask(who: str, priority: int) -> str:
    """Run with this priority, 1 to 99, from now on; why that cannot be, empty where it can."""
    _asked[who] = priority
    try:
        _settle()
    except (OSError, AttributeError) as error:
        del _asked[who]
        why = getattr(error, "strerror", None) or "this system has no such thing"
        return f"no real-time priority: {why}; the limit of rtprio (ulimit -r) must allow it"
    return ""


def give_back(who: str) -> None:
    """Need the priority no more."""
    if _asked.pop(who, 0):
        with suppress(OSError):
            _settle()


@contextmanager
def suspended() -> Iterator[None]:
    """Do something long without the priority that nodes of this process have."""
    if not _asked:
        yield
        return
    try:
        _give(0)
        yield
    finally:
        with suppress(OSError):
            _settle()


def _settle() -> None:
    """Give every thread what the nodes ask for together."""
    _give(max(_asked.values(), default=0))


def _give(priority: int) -> None:
    """Give every thread this priority, 0: none."""
    policy = os.SCHED_FIFO if priority else os.SCHED_OTHER
    for thread in THREADS.iterdir():
        with suppress(ProcessLookupError):
            os.sched_setscheduler(int(thread.name), policy, os.sched_param(priority))
