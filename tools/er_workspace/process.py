"""Running the programs of the set-up: quiet, logged, and gone when we go."""

from __future__ import annotations

import fcntl
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from er_workspace.layout import Stop

INTERRUPTED = 130
Command = Sequence[str | Path]


def say(line: str, end: str = "\n") -> None:
    """Progress goes to stderr, so that stdout carries results only."""
    sys.stderr.write(line + end)
    sys.stderr.flush()


@contextmanager
def step(title: str) -> Iterator[None]:
    """Print a title, and when the step ends, how long it took."""
    say(f"er: {title} ... ", end="")
    start = time.monotonic()
    try:
        yield
    except BaseException:
        say(f"failed after {time.monotonic() - start:.1f} s")
        raise
    say(f"{time.monotonic() - start:.1f} s")


@contextmanager
def locked(root: Path) -> Iterator[int]:
    """Hold the checkout's lock; yields its descriptor.

    The lock lies on the folder itself: there is no file to lose. Children that inherit the
    descriptor keep it locked when this process is killed, so nobody starts over while an orphan
    is still writing.
    """
    descriptor = os.open(root, os.O_RDONLY | os.O_DIRECTORY)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            say("er: waiting for another ./er that is setting up this checkout")
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield descriptor
    finally:
        os.close(descriptor)


def run_logged(
    command: Command, log: Path, env: Mapping[str, str], lock: int, failure: str
) -> None:
    """Run a command with its output appended to log.

    Raises:
        Stop: the command failed; says what, the output's most telling line, and the log's path.
    """
    run_together([(command, failure)], log, env, lock)


def run_together(
    jobs: Sequence[tuple[Command, str]], log: Path, env: Mapping[str, str], lock: int
) -> None:
    """Run commands side by side as `run_logged` does one; each comes with what is said when it fails."""
    log.parent.mkdir(parents=True, exist_ok=True)
    children: list[subprocess.Popen[bytes]] = []
    with log.open("a", encoding="utf-8") as sink:
        begin = sink.seek(0, os.SEEK_END)
        try:
            for command, _ in jobs:
                sink.write(f"$ {' '.join(map(str, command))}\n")
                sink.flush()
                child = subprocess.Popen(
                    list(map(str, command)), stdin=subprocess.DEVNULL, stdout=sink, stderr=sink,
                    env=dict(env), pass_fds=(lock,), start_new_session=True,
                )  # fmt: skip
                children.append(child)
            statuses = [child.wait() for child in children]
        except BaseException:
            for child in children:
                _end(child)
            raise
    for status, (_, failure) in zip(statuses, jobs):
        if status != 0:
            raise Stop(f"{failure}: {_telling_line(log, begin)} (log: {log})", 2)


def _end(child: subprocess.Popen[bytes]) -> None:
    """End the child and everything it started."""
    for number in (signal.SIGTERM, signal.SIGKILL):
        try:
            os.killpg(child.pid, number)
            child.wait(timeout=5.0)
        except ProcessLookupError:
            return
        except subprocess.TimeoutExpired:
            continue
    child.wait()


def _telling_line(log: Path, begin: int) -> str:
    """First line of the output that looks like an error, else the last one."""
    with log.open("rb") as source:
        source.seek(begin)
        text = source.read().decode(errors="replace")
    lines = [line.strip() for line in text.splitlines() if line.strip() and line[:2] != "$ "]
    if any(
        "Failed to establish a new connection" in line or "Name or service not known" in line
        for line in lines
    ):
        return "no network, the package index cannot be reached"
    errors = [line for line in lines if re.search(r"\berror\b", line, re.IGNORECASE)]
    return (errors or lines[-1:] or ["no output"])[0][:200]
