"""SIGINT and SIGTERM: noted, never a traceback; heard also while a node is still being made."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic
from types import FrameType
from typing import Any

#: one wish to stop may arrive as several signals: a dying parent's threads each send theirs, a
#: terminal and a supervisor both pass Ctrl-C on. What follows the first this soon is the same [s]
SAME_WISH = 1.0
#: a node that is still being made is told again this often that it shall end: code that runs when the
#: compiler tidies up swallows exceptions [s]
TOLD_AGAIN = 0.2


class Stopped:
    """Set by the first SIGINT or SIGTERM; one that follows later ends the process at once.

    What is done under `making` gets KeyboardInterrupt too: nodes that compile take long.
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
        """A signal raises KeyboardInterrupt in here, again and again until it gets out."""
        alarm = signal.signal(signal.SIGALRM, self._on_alarm)
        hook, sys.unraisablehook = sys.unraisablehook, _quiet(sys.unraisablehook)
        self._making = True
        try:
            yield
        finally:
            self._making = False
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGALRM, alarm)
            sys.unraisablehook = hook

    def _on_alarm(self, _number: int, _: FrameType | None) -> None:
        if self._making:
            raise KeyboardInterrupt

    def _on_signal(self, number: int, _: FrameType | None) -> None:
        if not self.signal:
            self.signal, self._since = number, monotonic()
            if self._making:
                signal.setitimer(signal.ITIMER_REAL, TOLD_AGAIN, TOLD_AGAIN)
                raise KeyboardInterrupt
        elif monotonic() - self._since > SAME_WISH:
            signal.signal(number, signal.SIG_DFL)
            signal.raise_signal(number)


def _quiet(hook: Callable[[Any], object]) -> Callable[[Any], object]:
    """The hook for exceptions that nobody can catch, without those that were raised to be told again."""

    def unless_told_again(unraisable: Any) -> object:
        return None if unraisable.exc_type is KeyboardInterrupt else hook(unraisable)

    return unless_told_again
