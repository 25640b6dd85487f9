"""SIGINT and SIGTERM: noted, never a traceback; heard also while a node is still being made."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from time import monotonic
from types import FrameType
from typing import Any

#: one wish to stop may arrive as several signals: a dying parent's threads each send theirs, a
#: terminal and a supervisor both pass Ctrl-C on. What follows the first this soon is the same [s]
SAME_WISH = 1.0

_UNDO: list[Callable[[], None]] = []


def on_leaving(undo: Callable[[], None]) -> None:
    """What takes back what was made so far, where a signal ends the process under `making`."""
    _UNDO.append(undo)


class Stopped:
    """Set by the first SIGINT or SIGTERM; one that follows later ends the process at once.

    What is done under `making` is ended at once: nodes that compile take long.
    """

    def __init__(self) -> None:
        """Nothing has arrived yet."""
        self.signal, self._since = 0, 0.0
        self._making = False
        self._before: dict[int, Any] = {}

    def __enter__(self) -> Stopped:
        """Start to watch."""
        for number in (signal.SIGINT, signal.SIGTERM):
            self._before[number] = signal.signal(number, self._on_signal)
        return self

    def __exit__(self, *_: object) -> None:
        """Give the signals back."""
        for number, handler in self._before.items():
            signal.signal(number, handler)

    @contextmanager
    def making(self) -> Iterator[None]:
        """A signal ends the process in here, with success: nothing has begun that must be ended well."""
        self._making = True
        try:
            yield
        finally:
            self._making = False

    def _on_signal(self, number: int, _: FrameType | None) -> None:
        if not self.signal:
            self.signal, self._since = number, monotonic()
            if self._making:
                _leave()
        elif monotonic() - self._since > SAME_WISH:
            signal.signal(number, signal.SIG_DFL)
            signal.raise_signal(number)


def _leave() -> None:
    """End at once: an exception that is raised inside the compiler, or a shutdown under it, can end in a crash."""
    for undo in _UNDO:
        with suppress(Exception):
            undo()
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError, RuntimeError):
            stream.flush()
    os._exit(0)
