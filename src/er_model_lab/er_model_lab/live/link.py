"""The process that listens to the running graph, as its owner sees it: words come by themselves, wishes go to it.

It is `er_model_lab.ros_live`. A word is a line of JSON: `rows` (`join.Row`), `again` (time began anew), `status` of the
monitor, `used` and `ran` (answers to `use` and `run`), `alone` (nobody says a sample), `model` (file that the monitor
began with). It ends when its standard input does.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from threading import Thread
from typing import Any

CHILD = "er_model_lab.ros_live"


class Link:
    """A process that listens in a namespace; heard: told each of its words, from a thread of its own."""

    def __init__(self, namespace: str, heard: Callable[[dict[str, Any]], None]) -> None:
        self.namespace, self.ended = namespace, ""
        command = [sys.executable, "-m", CHILD, namespace]
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(
            command, stdin=pipe, stdout=pipe, stderr=pipe, text=True, start_new_session=True
        )
        self._reader = Thread(target=self._read, args=(heard,), name="heard", daemon=True)
        self._reader.start()

    def use(self, model: str, *, observers: bool = False) -> None:
        """Ask the monitor, and the observers there are, to go by a model's file; `used` is the monitor's answer."""
        self._say({"use": model, "observers": observers})

    def run(self, program: str) -> None:
        """Ask who drives to drive a program's file now, or with "" to end it; `ran` is the answer."""
        self._say({"run": program})

    def stop(self) -> None:
        """End it."""
        if self._process.stdin is not None:
            self._process.stdin.close()
        try:
            self._process.wait(5.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def _say(self, content: dict[str, Any]) -> None:
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(f"{json.dumps(content)}\n")
            self._process.stdin.flush()
        except OSError:  # it has ended: `ended` says why
            return

    def _read(self, heard: Callable[[dict[str, Any]], None]) -> None:
        process = self._process
        assert process.stdout is not None
        assert process.stderr is not None
        for line in process.stdout:
            heard(json.loads(line))
        said = process.stderr.read().strip().splitlines()
        self.ended = said[-1] if said else "the process that listens has ended"
        heard({"ended": self.ended})
