"""Signals while something is made: what was made so far is taken back."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest
from er_ros_common.stopping import Stopped

from er_ros_common import stopping


def test_what_is_half_made_is_taken_back_whatever_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[str] = []
    monkeypatch.setattr(stopping, "_UNDO", [lambda: 1 / 0])
    monkeypatch.setattr(os, "_exit", lambda status: done.append(f"exit {status}"))
    stopping.on_leaving(lambda: done.append("undone"))
    with Stopped() as stopped, stopped.making():
        signal.raise_signal(signal.SIGTERM)
    assert done == ["undone", "exit 0"]
    with Stopped():
        signal.raise_signal(signal.SIGTERM)
    assert done == ["undone", "exit 0"]


#: a program whose last object hears a signal while the interpreter is taken down
ENDING = """
import os, signal, sys, types
from er_common.program import Program
from er_ros_common import entry

class Late:
    def __del__(self, kill=os.kill, own=os.getpid(), number=signal.{name}):
        kill(own, number)

late = Late()
made, work = types.ModuleType("made.programs"), types.ModuleType("made.work")
made.PROGRAMS = (types.SimpleNamespace(name="work", core=None, path="made.work"),)
work.main = lambda: sys.exit(3)
sys.modules.update({{"made": types.ModuleType("made"), "made.programs": made, "made.work": work}})
entry.start("made", "work")
"""


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_a_signal_to_a_process_that_is_nearly_gone_does_not_change_its_status(name: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", ENDING.format(name=name)], capture_output=True, text=True
    )
    assert (done.returncode, done.stderr) == (3, "")
