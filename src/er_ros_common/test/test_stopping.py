"""Signals while something is made: what was made so far is taken back."""

from __future__ import annotations

import os
import signal

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
