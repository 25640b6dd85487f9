"""A lock between processes that the end of a process gives back."""

from __future__ import annotations

import fcntl
import os
import time
from pathlib import Path

PATIENCE, LOOK = 120.0, 0.02
"""Longest wait for another process, which may be stopped, and how often it is asked whether it is ready [s]."""


def locked(path: Path) -> int | None:
    """A file that is locked until it is closed; None where it cannot be made, or after `PATIENCE`."""
    try:
        file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o600)
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
