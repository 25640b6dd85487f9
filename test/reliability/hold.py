"""A recorder that is held up: what its recording lacks afterwards, in lockstep and in real time."""

from __future__ import annotations

import os
import signal
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from time import sleep

from er_records.recording.message_count import header_of
from rosbags.highlevel import AnyReader

from er_common import topics
from test.graph_help import Graph, Running, own_domain

HOLDS = (0.3, 1.0, 3.0)
"""How long the recorder does not run [s]."""
MODES = {
    "lockstep, at twice the pace": ("mode:=lockstep", "rate_factor:=2.0"),
    "lockstep, as fast as it goes": ("mode:=lockstep", "rate_factor:=0"),
    "real time": (),
}
PACES = dict(zip(MODES, (2.0, 10.0, 1.0), strict=True))
"""Simulated seconds that pass in one, about."""
MEASURED = tuple(f"/{t.name}" for t in topics.MEASUREMENTS if t is not topics.PWM_COMMAND)
"""What the plant says of every tick; in real time it may go without a command."""
RATE = 200
MOVING = "plant]: running"
"""What `er up` prints once the plant ticks."""


def child(running: Running, program: str) -> int:
    """Process of a program that another one has started.

    Raises:
        LookupError: There is none.
    """
    for task in Path(f"/proc/{running.process.pid}/task").iterdir():
        for pid in (task / "children").read_text().split():
            command = Path(f"/proc/{pid}/cmdline").read_text().split("\0")
            if program in (Path(word).name for word in command[:2]):
                return int(pid)
    raise LookupError(program)


def hold(pid: int, seconds: float) -> None:
    """Stop a process for so long."""
    os.kill(pid, signal.SIGSTOP)
    try:
        sleep(seconds)
    finally:
        os.kill(pid, signal.SIGCONT)


def ticks_of(bag: Path, names: Sequence[str]) -> dict[str, set[int]]:
    """Ticks that a recording holds of these topics."""
    found: dict[str, set[int]] = {name: set() for name in names}
    with AnyReader([bag]) as reader:
        for connection, _, data in reader.messages():
            header = header_of(data)
            if connection.topic in found and header:
                found[connection.topic].add(header.seq)
    return found


def lacking(folder: Path, seconds: float, given: Sequence[str], duration: float) -> int:
    """Run a graph whose recorder is held up; how many messages of the plant its recording lacks."""
    folder.mkdir()
    bag = folder / "bag"
    with own_domain() as env, Graph(env, folder) as graph:
        more = ("observers:=none", f"duration:={duration}", f"record:={bag}")
        running = graph.start("up", *given, *more)
        running.wait_for(MOVING)
        sleep(0.2)
        hold(child(running, "recorder"), seconds)
        assert running.end(120.0) == 0, running.text
    whole = set(range(1, round(RATE * duration) + 1))
    return sum(len(whole - each) for each in ticks_of(bag, MEASURED).values())


def run(times: int) -> int:
    """Print what the recordings lack; 1 where one lacks anything."""
    worst = 0
    sys.stdout.write(
        "| mode | held up, s | messages of the plant | lacking |\n|---|---|---|---|\n"
    )
    with tempfile.TemporaryDirectory() as folder:
        for mode, given in MODES.items():
            for seconds in HOLDS:
                duration = 5.0 + seconds * (1.0 + PACES[mode])
                places = [Path(folder) / f"{mode} {seconds} {i}" for i in range(times)]
                found = [lacking(place, seconds, given, duration) for place in places]
                worst = max(worst, *found)
                count = len(MEASURED) * round(RATE * duration)
                each = ", ".join(map(str, found))
                sys.stdout.write(f"| {mode} | {seconds} | {count} | {each} |\n")
                sys.stdout.flush()
    return int(worst > 0)
