"""Of several processes that want a function one compiles it, and nobody waits for one that is gone."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from er_models.cache import sealed
from er_models.cache.compiled import on_disk
from er_models.cache.lock import locked

PROGRAM = """
import sys
import numba.core.event as event
from er_models.cache import lock

lock.PATIENCE = {patience}
compiled = []

class Listener(event.Listener):
    def on_start(self, e):
        compiled.append(e)
        if {stop}:
            print("compiling", flush=True)
            sys.stdin.read()

    def on_end(self, e):
        pass

event.register("numba:compile", Listener())
sys.path.insert(0, {folder!r})
from functions import outer
print(outer(2.0), len(compiled), flush=True)
"""
FUNCTIONS = """
from er_models.cache.compiled import on_disk

@on_disk(error_model="numpy")
def inner(x):
    return x + 1.0

@on_disk(error_model="numpy")
def outer(x):
    return 2.0 * inner(x)
"""


def start(folder: Path, *, stop: bool = False, patience: float = 60.0) -> subprocess.Popen[str]:
    """A process that calls a function of a module in the folder, and says what it gave and what it compiled."""
    program = PROGRAM.format(folder=str(folder), stop=stop, patience=patience)
    return subprocess.Popen(
        [sys.executable, "-c", program], text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        env=os.environ | {"ER_CACHE_DIR": str(folder / "cache")},
    )  # fmt: skip


def said(process: subprocess.Popen[str]) -> list[float]:
    """What it gave, and how many functions it compiled."""
    return [float(word) for word in process.communicate(timeout=100)[0].split()]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A module of two functions, one of which calls the other."""
    (tmp_path / "functions.py").write_text(FUNCTIONS, encoding="utf-8")
    return tmp_path


def test_each_function_is_compiled_by_one_of_several_processes(folder: Path) -> None:
    found = [said(each) for each in [start(folder) for _ in range(3)]]
    assert [value for value, _ in found] == [6.0] * 3
    assert sum(compiled for _, compiled in found) == 2
    assert said(start(folder)) == [6.0, 0.0]


@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGSTOP])
def test_nobody_waits_for_one_that_is_gone(folder: Path, end: signal.Signals) -> None:
    """A killed process holds no lock; one that is held up is waited for, but not for good."""
    first = start(folder, stop=True)
    assert first.stdout is not None
    assert first.stdout.readline().strip() == "compiling"
    first.send_signal(end)
    try:
        assert said(start(folder, patience=1.0)) == [6.0, 2.0]
    finally:
        first.kill()
        first.communicate()


def test_without_a_folder_for_the_lock_it_is_compiled_all_the_same(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    assert locked(tmp_path / "file" / "a.lock") is None


def test_a_full_disk_stops_nobody_and_the_lock_is_given_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("ER_CACHE_DIR", str(tmp_path))

    @on_disk()
    def plain(x: float) -> float:
        return x + 1.0

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(sealed, "write", full)
    assert plain(1.0) == 2.0
    assert "No space left on device: compiled code is not kept" in caplog.text
    (lock,) = tmp_path.rglob("*plain*.lock")
    file = locked(lock)
    assert file is not None
    os.close(file)


def test_what_no_file_stands_for_is_compiled_in_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A text that was executed, and a function that refers to variables of another one."""
    monkeypatch.setenv("ER_CACHE_DIR", str(tmp_path))
    namespace: dict[str, Any] = {}
    exec("def twice(x):\n    return 2.0 * x", namespace)
    assert on_disk()(namespace["twice"])(1.5) == 3.0

    def times(factor: float) -> Any:
        @on_disk()
        def scaled(x: float) -> float:
            return factor * x

        return scaled

    assert [times(factor)(1.5) for factor in (2.0, 4.0)] == [3.0, 6.0]
    assert not [*tmp_path.rglob("*.compiled")]
