"""The work of a diagnosis in a process of its own: whoever asked for it looks at it now and then and never waits.

What it is to learn from goes through a folder, how far it is comes as lines of JSON. It ends, with nothing, when its
standard input does: when it is cancelled, and when its owner dies, however that does.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from threading import Thread
from time import monotonic
from typing import Any

import numpy as np
from er_models.model import Array

PATIENCE = 10.0
"""How long after it was cancelled it may go on before it is killed [s]."""
CHILD = "er_model_lab.monitor.learner"
TASK, HEARD = "task.json", "heard.npz"


@dataclass(frozen=True)
class Task:
    """What is asked: the model file to begin with, a recording (empty: what was heard), the folder for new models."""

    model: str
    bag: str
    models: str


class Learning:
    """A diagnosis that is under way.

    told: what was said last of stage, done, best and best_rmse; result: the end, None before: by the names of
    `learner.learn`; cancelled: whether it was asked to stop.
    """

    def __init__(self, task: Task, heard: Mapping[str, Array]) -> None:
        """heard: what is learnt from where there is no recording, channels by name (n,)."""
        self.told: dict[str, Any] = {
            "stage": "starting",
            "done": 0.0,
            "best": "",
            "best_rmse": 0.0,
        }
        self.result: dict[str, Any] | None = None
        self.cancelled = False
        self._until, self._rest, self._begun = 0.0, b"", False
        self._folder = tempfile.TemporaryDirectory(prefix="er_learning_")
        self._process: subprocess.Popen[bytes] | None = None
        # to write and to start takes milliseconds, which a loop has not
        self._start = Thread(target=self._begin, args=(task, dict(heard)), daemon=True)
        self._start.start()

    def _begin(self, task: Task, heard: dict[str, Array]) -> None:
        folder = Path(self._folder.name)
        (folder / TASK).write_text(json.dumps(asdict(task)), encoding="utf-8")
        np.savez(folder / HEARD, allow_pickle=False, **heard)
        command = [sys.executable, "-m", CHILD, str(folder)]
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(command, stdin=pipe, stdout=pipe, start_new_session=True)
        os.set_blocking(self._process.stdout.fileno(), False)  # type: ignore[union-attr]

    def look(self) -> bool:
        """Take what it has said; whether that is something new. Never waits."""
        if self._start.is_alive() or self.result is not None:
            return False
        process = self._process
        if process is None or process.stdout is None:
            self._end({"reason": "the process that learns could not be started"})
            return True
        if self.cancelled and not self._until:
            self._until = monotonic() + PATIENCE
            if process.stdin is not None:
                process.stdin.close()
        ended = process.poll() is not None  # before the last look: what it said then is all
        new = self._read(process.stdout.read() or b"") or not self._begun
        self._begun = True
        if self.result is not None or ended:
            self._end(self.result or {"reason": self._why(process)})
            return True
        if self._until and monotonic() > self._until:
            process.kill()
        return new

    def _read(self, said: bytes) -> bool:
        *lines, self._rest = (self._rest + said).split(b"\n")
        for line in lines:
            content = json.loads(line)
            if "result" in content:
                self.result = content["result"]
            else:
                self.told |= content
        return bool(lines)

    def _why(self, process: subprocess.Popen[bytes]) -> str:
        return "cancelled" if self.cancelled else f"the process ended with status {process.poll()}"

    def _end(self, result: dict[str, Any]) -> None:
        self.result = result
        if self._process is not None:
            for pipe in (self._process.stdin, self._process.stdout):
                if pipe is not None:
                    pipe.close()
            if self._process.poll() is None:
                Thread(target=self._process.wait, daemon=True).start()
        self._folder.cleanup()

    def cancel(self) -> None:
        """Ask it to stop; `look` says when it has."""
        self.cancelled = True

    def stop(self) -> None:
        """End it now, however it is: its owner ends."""
        self._start.join()
        if self.result is None:
            if self._process is not None and self._process.poll() is None:
                self._process.kill()
                self._process.wait()
            self._end({"reason": "stopped"})
