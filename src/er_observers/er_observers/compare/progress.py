"""The progress bar of a comparison."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn


@contextmanager
def roads_done() -> Iterator[Callable[[int, int], None] | None]:
    """Roads done and of all, on a terminal only."""
    if not sys.stderr.isatty():
        yield None
        return
    shown = (TextColumn("roads"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*shown, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("roads", total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)
