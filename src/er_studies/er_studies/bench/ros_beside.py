"""What runs beside the control loop, and what that costs the loop: ages of messages and processor time.

Plant and controller run all the time. Beside them run, in turns: nothing; a node of plain rclpy with the monitor's
ends, which computes nothing; the monitor; the monitor and a busy loop on every core; monitor and live page. A browser
shows the page where there is one. Browser and busy loops have what all others leave of the machine: what the busy ones
cost the loop, any program costs it. An age is the time from the stamp of a sample until its answer was handed to the
middleware.
"""

from __future__ import annotations

import io
import os
import struct
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic, sleep

import numpy as np
import rclpy
from er_bringup.given import complete
from er_bringup.graph import nodes
from er_bringup.processes import Child, stop
from er_bringup.up import argv, configuration
from er_common.topics import MODEL_FORCE, PWM_COMMAND, Topic
from er_model_lab.programs import MONITOR
from er_models.constants import SAMPLE_TIME
from er_models.errors import ErError
from er_models.model import Array
from rclpy.node import Node

from er_common import quality
from er_ros_common import qos
from er_studies.bench import browser
from er_studies.bench.graph import usage
from er_studies.bench.ros import START
from er_studies.given_out import Table

NOTHING, PLAIN, LIVE, PAGE = "nothing", "plain rclpy", "live page", "monitor and live page"
BUSY = "monitor and busy loops"
PHASES = (NOTHING, PLAIN, MONITOR.name, BUSY, PAGE)
SPIN = """
import os
os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
print("busy", flush=True)
while True:
    pass
"""
ROUNDS = 3
"""How often each has its turn."""
SETTLE = 2.0
"""Time after something was started or ended that does not count [s]."""
PERIOD = 0.2
"""How often what has come is taken [s]."""
STAMP = struct.Struct("<iI")


@dataclass
class Phase:
    """What was seen with something beside the loop.

    loop, answers: ages of the controller's and of the monitor's answers, a row a turn [ms]; due: samples in all turns;
    cpu: of what runs beside the loop [% of a core], by turn; parts: of each of its processes, over all turns.
    """

    loop: list[Array] = field(default_factory=list)
    answers: list[Array] = field(default_factory=list)
    due: int = 0
    cpu: list[float] = field(default_factory=list)
    parts: dict[str, float] = field(default_factory=dict)

    @property
    def late(self) -> float:
        """Share of the samples whose prediction was not there before the next sample was due, or never."""
        return self._late(self.answers)

    @property
    def late_loop(self) -> float:
        """The same of the controller's answers: what of it is the machine's."""
        return self._late(self.loop)

    def _late(self, turns: list[Array]) -> float:
        return 1.0 - sum(int((a <= 1e3 * SAMPLE_TIME).sum()) for a in turns) / self.due


def ratio(phase: Phase, to: Phase) -> float:
    """The loop's p99 over that with something else beside it: the median of the turns."""
    each = [
        np.percentile(a, 99.0) / np.percentile(b, 99.0)
        for a, b in zip(phase.loop, to.loop, strict=True)
    ]
    return float(np.median(each))


class Ears:
    """Takes what the graph says, as bytes: stamp and age of each message, by topic."""

    def __init__(self, node: Node) -> None:
        self.ends = {
            topic: node.create_subscription(
                topic.type, topic.name, _nothing, qos.profile(quality.FOLLOWER), raw=True
            )
            for topic in (PWM_COMMAND, MODEL_FORCE)
        }

    def take(self) -> dict[Topic, list[tuple[int, float]]]:
        """All that has come: stamps [ns] and ages [ms]."""
        found: dict[Topic, list[tuple[int, float]]] = {}
        for topic, end in self.ends.items():
            each = found[topic] = []
            with end.handle:
                while (got := end.handle.take_message(end.msg_type, True)) is not None:
                    seconds, nanoseconds = STAMP.unpack_from(got[0], 4)
                    stamp = seconds * 1_000_000_000 + nanoseconds
                    each.append((stamp, 1e-6 * (got[1]["source_timestamp"] - stamp)))
        return found

    def wait(
        self, there: Callable[[dict[Topic, list[tuple[int, float]]]], bool], what: str
    ) -> None:
        """Until something has come."""
        until = monotonic() + START
        while not there(self.take()):
            if monotonic() > until:
                raise ErError(f"{what} did not come within {START:g} s")
            sleep(PERIOD)

    def listen(self, seconds: float) -> dict[Topic, list[tuple[int, float]]]:
        """What comes in so many seconds."""
        found: dict[Topic, list[tuple[int, float]]] = {topic: [] for topic in self.ends}
        self.take()
        until = monotonic() + seconds
        while monotonic() < until:
            sleep(PERIOD)
            for topic, each in self.take().items():
                found[topic] += each
        return found


def _nothing(_: bytes) -> None:
    """No callback: messages are taken."""


def measured(seconds: float) -> dict[str, Phase]:
    """Every phase, for so many seconds in all its turns together."""
    given = complete({"observers": "none", "program": "identification", "duration": "0"})
    watched = complete({
        "observers": "none", "program": "identification", "duration": "0", "model_monitor": "true",
    })  # fmt: skip
    monitor = next(s for s in nodes(watched, configuration()) if s.executable == MONITOR.name)
    out, phases = io.StringIO(), {name: Phase() for name in PHASES}
    loop = [Child(s.executable, argv(s), out) for s in nodes(given, configuration())]
    rclpy.init(args=[])
    try:
        ears = Ears(Node("bench", enable_rosout=False))
        ears.wait(lambda found: len(found[PWM_COMMAND]) > 0, "the first command")
        for _ in range(ROUNDS):
            part = seconds / ROUNDS
            _turn(ears, phases[NOTHING], loop, {}, part)
            with _beside(PLAIN, [sys.executable, "-m", "er_studies.bench.ros_plain"]) as plain:
                _turn(ears, phases[PLAIN], loop, {PLAIN: plain}, part)
            with _beside(MONITOR.name, argv(monitor)) as watching:
                ears.wait(lambda found: len(found[MODEL_FORCE]) > 0, "the first prediction")
                _turn(ears, phases[MONITOR.name], loop, {MONITOR.name: watching}, part)
                with ExitStack() as loops:
                    for _ in range(os.cpu_count() or 1):
                        loops.enter_context(_busy())
                    _turn(ears, phases[BUSY], loop, {MONITOR.name: watching}, part)
                with _shown() as page:
                    both = {MONITOR.name: watching, LIVE: page}
                    _turn(ears, phases[PAGE], loop, both, part)
    finally:
        stop(loop)
        rclpy.try_shutdown()
    return phases


def _turn(
    ears: Ears, phase: Phase, loop: Sequence[Child], beside: dict[str, Child], seconds: float
) -> None:
    """Measure for so many seconds, with these processes beside the loop."""
    sleep(SETTLE)
    each = {c.label: [c.process.pid] for c in loop}
    each |= {name: family(child.process.pid) for name, child in beside.items()}
    before, began = _used(each), monotonic()
    found = ears.listen(seconds)
    after, took = _used(each), monotonic() - began
    shares = {name: 100.0 * (after[name] - before[name]) / took for name in each}
    for name, share in shares.items():
        phase.parts[name] = phase.parts.get(name, 0.0) + share / ROUNDS
    phase.cpu.append(sum(shares[name] for name in beside))
    stamps = [stamp for stamp, _ in found[PWM_COMMAND]]
    phase.due += round((stamps[-1] - stamps[0]) / (1e9 * SAMPLE_TIME)) + 1
    within = [age for stamp, age in found[MODEL_FORCE] if stamps[0] <= stamp <= stamps[-1]]
    phase.loop.append(np.array([age for _, age in found[PWM_COMMAND]]))
    phase.answers.append(np.array(within))


def family(pid: int) -> list[int]:
    """A process and those that it has started, and they."""
    found = [pid]
    for each in found:
        for file in Path(f"/proc/{each}/task").glob("*/children"):
            found += map(int, file.read_text(encoding="utf-8").split())
    return found


def _used(each: dict[str, list[int]]) -> dict[str, float]:
    """Processor time by name [s]."""
    found = {}
    for name, pids in each.items():
        used = [usage(pid) for pid in pids]
        if used[0] is None:
            raise ErError(f"{name} ended")
        found[name] = sum(u.cpu for u in used if u is not None)
    return found


@contextmanager
def _beside(label: str, command: Sequence[str], out: io.StringIO | None = None) -> Iterator[Child]:
    """A process, ended behind it."""
    child = Child(label, command, out or io.StringIO())
    try:
        yield child
    finally:
        stop([child])


@contextmanager
def _busy() -> Iterator[None]:
    """A loop that is busy with nothing while all others leave it a core."""
    said = io.StringIO()
    with _beside("busy", [sys.executable, "-c", SPIN], said):
        _read(said, "busy")
        yield


@contextmanager
def _shown() -> Iterator[Child]:
    """The live page, in a browser where there is one; it shows the graph."""
    said, seen = io.StringIO(), io.StringIO()
    with _beside("page", [sys.executable, "-m", "er_studies.bench.live_page"], said) as page:
        _read(said, "http://")
        if not browser.found():
            yield page
            return
        address = f"http://{said.getvalue().split('http://')[1].split()[0]}"
        command = [sys.executable, "-m", "er_studies.bench.browser", address]
        with _beside("browser", command, seen):
            _read(seen, browser.SHOWN)
            yield page


def _read(said: io.StringIO, words: str) -> None:
    """Until a process has said something."""
    until = monotonic() + START
    while words not in said.getvalue():
        if monotonic() > until:
            raise ErError(f"{words} did not come within {START:g} s: {said.getvalue()[-200:]}")
        sleep(PERIOD)


def tables(phases: dict[str, Phase]) -> list[Table]:
    """The loop with each of what runs beside it, and what each process takes of a core."""
    rows = []
    for name, phase in phases.items():
        ages = np.percentile(np.concatenate(phase.loop), (50.0, 99.0, 99.9))
        size = [f"{each:.2f}" for each in (*ages, ratio(phase, phases[NOTHING]))]
        watches = name not in (NOTHING, PLAIN)
        late = [f"{share:.2%}" if watches else "" for share in (phase.late, phase.late_loop)]
        rows.append([name, *size, f"{np.mean(phase.cpu):.1f}", *late])
    head = [
        "beside plant and controller", "loop p50 ms", "p99", "p99.9", "p99 over that beside nothing", "% of a core",
        "predictions late", "answers of the controller late",
    ]  # fmt: skip
    own = phases[MONITOR.name].parts[MONITOR.name]
    parts = {**phases[PAGE].parts, **phases[PLAIN].parts, **phases[MONITOR.name].parts}
    shares = [[name, f"{share:.1f}", f"{own / share:.2f}"] for name, share in parts.items()]
    return [
        Table(head, rows),
        Table(["process", "% of a core", "the monitor's share over it"], shares),
    ]
