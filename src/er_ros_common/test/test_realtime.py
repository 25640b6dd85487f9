"""Real-time priority: of every thread, the highest asked for, given back, and refused in words."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from er_ros_common import realtime


@pytest.fixture
def system(monkeypatch: pytest.MonkeyPatch) -> dict[int, tuple[int, int]]:
    """What the system was told of each thread: policy and priority."""
    told: dict[int, tuple[int, int]] = {}

    def note(thread: int, policy: int, given: os.sched_param) -> None:
        told[thread] = policy, given.sched_priority

    monkeypatch.setattr(os, "sched_setscheduler", note)
    monkeypatch.setattr(realtime, "_asked", {})
    return told


@pytest.fixture
def second() -> Iterator[int]:
    """Another thread of this process."""
    over, there = threading.Event(), threading.Event()
    thread = threading.Thread(target=lambda: (there.set(), over.wait()))
    thread.start()
    there.wait()
    yield thread.native_id or 0
    over.set()
    thread.join()


def test_all_threads_get_the_highest_priority_of_those_that_act(
    system: dict[int, tuple[int, int]], second: int
) -> None:
    own = threading.get_native_id()
    for who, priority, most in (
        ("/plant", 40, 40),
        ("/observer", 20, 40),
        ("/controller", 60, 60),
    ):
        assert realtime.ask(who, priority) == ""
        assert system[own] == system[second] == (os.SCHED_FIFO, most)
    realtime.give_back("/controller")
    assert system[own] == system[second] == (os.SCHED_FIFO, 40)
    for who in ("/observer", "/plant"):
        realtime.give_back(who)
    assert system[own] == system[second] == (os.SCHED_OTHER, 0)


def test_something_long_is_done_without(system: dict[int, tuple[int, int]]) -> None:
    """Of several nodes in a process one may compile while another acts already."""
    own = threading.get_native_id()
    with realtime.suspended():
        assert system == {}, "nobody had asked"
    realtime.ask("/plant", 40)
    with realtime.suspended():
        assert system[own] == (os.SCHED_OTHER, 0)
    assert system[own] == (os.SCHED_FIFO, 40)


def test_who_asked_for_nothing_changes_nothing(system: dict[int, tuple[int, int]]) -> None:
    realtime.give_back("/plant")
    assert system == {}


def test_a_refusal_is_said_and_forgotten(
    system: dict[int, tuple[int, int]], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    with monkeypatch.context() as patch:
        patch.setattr(os, "sched_setscheduler", refuse)
        said = realtime.ask("/plant", 40)
    assert "Operation not permitted" in said
    assert "ulimit -r" in said
    realtime.give_back("/plant")
    assert system == {}


def test_a_thread_that_ends_meanwhile_is_no_matter(
    system: dict[int, tuple[int, int]], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for name in ("1", "2"):
        (tmp_path / name).mkdir()
    monkeypatch.setattr(realtime, "THREADS", tmp_path)

    def note(thread: int, policy: int, given: os.sched_param) -> None:
        if thread == 1:
            raise ProcessLookupError
        system[thread] = policy, given.sched_priority

    monkeypatch.setattr(os, "sched_setscheduler", note)
    assert realtime.ask("/plant", 7) == ""
    assert system == {2: (os.SCHED_FIFO, 7)}
