"""A job for other processes: a function with what all its jobs share, which is sent to each process once."""

from __future__ import annotations

import pickle
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from uuid import uuid4

from er_model_lab.blas import on_one_thread
from er_model_lab.jobs.processes import UNSENT


class _Here(threading.local):
    """Whether this thread does a job."""

    busy = False


_here = _Here()
_opened: dict[str, tuple[Any, ...]] = {}
"""What was sent to this process last."""


def inside_a_job() -> bool:
    """Whether this thread does a job: what that hands out it does itself, since all others may wait as it would."""
    return _here.busy


@dataclass(frozen=True)
class Call:
    """What is done with each job of a stage; content: what they share.

    sealed: the same for other processes as bytes, or the file that holds it; None: it stays in this one.
    """

    function: Callable[..., Any]
    content: tuple[Any, ...] | None
    name: str = ""
    sealed: bytes | Path | None = None

    def __call__(self, job: Any) -> Any:
        """Do one job, here or where this was sent."""
        _here.busy = True
        try:
            if self.content is not None:
                return self.function(job, *self.content)
            return on_one_thread(self.function)(job, *self._arrived())
        finally:
            _here.busy = False

    def __reduce__(self) -> tuple[Any, ...]:
        return Call, (self.function, None, self.name, self.sealed)

    def _arrived(self) -> tuple[Any, ...]:
        """What the jobs share, in another process; what was sent before is thrown away."""
        content = _opened.get(self.name)
        if content is None:
            sealed = self.sealed
            _opened.clear()
            assert sealed is not None
            content = pickle.loads(sealed if isinstance(sealed, bytes) else sealed.read_bytes())
            _opened[self.name] = content
        return content

    def discard(self) -> None:
        """Throw away its file."""
        if isinstance(self.sealed, Path):
            self.sealed.unlink(missing_ok=True)


def packed(call: Call, folder: Path | None = None) -> Call | None:
    """A call for other processes; None where what its jobs share cannot be sent.

    folder: where those may read a file, so that not every job carries it.
    """
    try:
        sealed = pickle.dumps(call.content, pickle.HIGHEST_PROTOCOL)
    except UNSENT:
        return None
    name = uuid4().hex
    if folder is None:
        return Call(call.function, call.content, name, sealed)
    (folder / name).write_bytes(sealed)
    return Call(call.function, call.content, name, folder / name)
