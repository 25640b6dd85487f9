"""Work beside the page: one job at a time, in a thread, that says how far it is and can be cancelled."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from er_models.errors import ErError, InputError

from er_model_lab.work import Cancelled, Leader, Progress


@dataclass(frozen=True)
class Job:
    """How far a job is; leaders: effects that are ahead, best first; error: why it ended without a result."""

    title: str
    stage: str = ""
    done: int = 0
    total: int = 0
    leaders: tuple[Leader, ...] = ()
    running: bool = True
    error: str = ""


class Jobs:
    """Does one job at a time; told: called from the job's thread whenever something has changed."""

    def __init__(self, told: Callable[[], None]) -> None:
        self.job: Job | None = None
        self._told, self._cancel = told, threading.Event()
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None

    @property
    def running(self) -> bool:
        """Whether a job is at work."""
        return self.job is not None and self.job.running

    def start(self, title: str, work: Callable[[Progress, threading.Event], Any]) -> None:
        """Begin a job: a function of what it reports to, and of the event that ends it.

        Raises:
            InputError: Another one is at work.
        """
        with self._lock:
            if self.running:
                raise InputError(
                    title,
                    "",
                    "one job at a time: wait, or cancel",
                    self.job.title if self.job else "",
                )
            self.job, self._cancel = Job(title), threading.Event()
        self._thread = threading.Thread(
            target=self._run, args=(work, self._cancel), name=title, daemon=True
        )
        self._thread.start()
        self._told()

    def cancel(self) -> None:
        """End the job within a second; what was found stays."""
        self._cancel.set()

    def wait(self, seconds: float | None = None) -> None:
        """Until the job has ended."""
        if self._thread is not None:
            self._thread.join(seconds)

    def _run(
        self, work: Callable[[Progress, threading.Event], Any], cancel: threading.Event
    ) -> None:
        error = ""
        try:
            work(self._progress, cancel)
        except Cancelled:
            error = "cancelled before anything was found"
        except ErError as failed:
            error = " ".join(str(failed).split())
        except Exception as failed:  # the page goes on whatever a job meets
            error = f"{type(failed).__name__}: {failed}"
        self._change(running=False, error=error)

    def _progress(self, stage: str, done: int, total: int, leaders: tuple[Leader, ...]) -> None:
        self._change(stage=stage, done=done, total=total, leaders=leaders)

    def _change(self, **what: Any) -> None:
        if self.job is not None:
            self.job = replace(self.job, **what)
        self._told()
