"""How the graph performs on this machine: losses, rates, latencies, processor time, as Markdown.

    ./er bench graph --seconds 60

Starts plant, observer and recorder (and, with --controller, the closed loop) as separate
processes, and reads everything from the recording. The age of a message is the time from its
measurement (the stamp) to its arrival at the recorder: for an estimate that is the whole way,
plant to observer to recorder.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import monotonic, sleep

import numpy as np
from er_bringup.given import complete
from er_bringup.graph import nodes
from er_bringup.processes import Child, stop
from er_bringup.up import argv, configuration
from er_model_lab.programs import RECORDER
from er_models.errors import ErError
from er_models.one_line import OneLine
from er_plant_sim.programs import PLANT
from numpy.typing import NDArray
from rosbags.highlevel import AnyReader

from er_studies.bench.machine import machine
from er_studies.given_out import Table, give

WARM_UP = 1.0
"""Beginning of a run that does not count [s]."""
PERCENTILES = (50.0, 99.0, 99.9, 100.0)
_TICKS = os.sysconf("SC_CLK_TCK")
_PAGE = os.sysconf("SC_PAGE_SIZE")


@dataclass(frozen=True)
class Usage:
    """What a process has used: processor time [s] and resident memory [bytes]."""

    cpu: float
    memory: int


@dataclass(frozen=True)
class Load:
    """Share of one core [%] and resident memory [MB] of one process."""

    name: str
    cpu: float
    memory: float


@dataclass(frozen=True)
class Flow:
    """One topic after the warm-up: messages, lost ones, rate [Hz], ages [ms] at `PERCENTILES`."""

    topic: str
    count: int
    lost: int
    rate: float
    ages: tuple[float, ...]


def usage(pid: int) -> Usage | None:
    """Usage of a process so far; None once it has ended."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()
    except (FileNotFoundError, ProcessLookupError):
        return None
    if fields[0] == "Z":
        return None
    return Usage((int(fields[11]) + int(fields[12])) / _TICKS, int(fields[21]) * _PAGE)


def flow(topic: str, seq: NDArray[np.int64], stamps: NDArray[np.int64],
         arrivals: NDArray[np.int64], start: int) -> Flow:  # fmt: skip
    """Figures of a topic; seq (n,), stamps and arrivals (n,) [ns], start of the run [ns]."""
    kept = stamps > start + int(1e9 * WARM_UP)
    seq, stamps, arrivals = seq[kept], stamps[kept], arrivals[kept]
    lost = int(np.maximum(np.diff(seq) - 1, 0).sum())
    span = 1e-9 * float(stamps[-1] - stamps[0])
    ages = 1e-6 * np.percentile(arrivals - stamps, PERCENTILES)
    return Flow(topic, len(seq), lost, (len(seq) - 1) / span, tuple(float(a) for a in ages))


def flows(bag: Path) -> list[Flow]:
    """Figures of every topic that runs at the rate of the plant."""
    rows: dict[str, list[tuple[int, int, int]]] = {}
    with AnyReader([bag]) as reader:
        for connection, arrival, data in reader.messages():
            ours = connection.msgtype.startswith("er_damper_msgs/")
            if ours and not connection.topic.endswith("/status"):
                m = reader.deserialize(data, connection.msgtype)
                stamp = m.header.stamp.sec * 1_000_000_000 + m.header.stamp.nanosec  # type: ignore[attr-defined]
                if m.status != m.STATUS_LOST:  # type: ignore[attr-defined]
                    rows.setdefault(connection.topic, []).append((m.seq, stamp, arrival))  # type: ignore[attr-defined]
    start = min(stamp for each in rows.values() for _, stamp, _ in each)
    tables = {topic: np.array(each, np.int64) for topic, each in sorted(rows.items())}
    return [flow(topic, t[:, 0], t[:, 1], t[:, 2], start) for topic, t in tables.items()]


def run(seconds: float, bag: Path, *, controller: bool) -> list[Load]:
    """Run the graph into a recording; processor time and memory of every process."""
    given = {
        "duration": str(seconds + WARM_UP),
        "record": str(bag),
        "controller": "skyhook" if controller else "none",
    }
    out = sys.stderr
    children = [Child(s.executable, argv(s), out) for s in nodes(complete(given), configuration())]
    try:
        return _measured(children, bag)
    finally:
        stop([child for child in children if child.label != RECORDER.name])
        stop([child for child in children if child.label == RECORDER.name])


def _measured(children: Sequence[Child], bag: Path) -> list[Load]:
    """Wait for the run to begin, then measure until the plant ends."""
    plant = next(child for child in children if child.label == PLANT.name)
    _wait_for_data(plant, bag)
    sleep(WARM_UP)
    began, before = monotonic(), {c.label: usage(c.process.pid) for c in children}
    after = before
    while plant.status is None:
        after = {c.label: usage(c.process.pid) or after[c.label] for c in children}
        elapsed = monotonic() - began
        sleep(0.2)
    loads = []
    for label, first in before.items():
        last = after[label]
        if first is not None and last is not None:
            loads.append(Load(label, 100.0 * (last.cpu - first.cpu) / elapsed, last.memory / 1e6))
    return loads


def _wait_for_data(plant: Child, bag: Path) -> None:
    """Wait until the recording grows; its file holds 200 messages a second and topic."""
    while not any(p.stat().st_size > 20_000 for p in bag.glob("*.mcap")):
        if plant.status is not None:
            raise ErError(f"plant ended with exit status {plant.status} before it began")
        sleep(0.05)


def tables(found: Sequence[Flow], loads: Sequence[Load]) -> tuple[Table, Table]:
    """The topics, and the processes."""
    head = ["topic", "messages", "lost", "Hz", "age ms p50", "p99", "p99.9", "max"]
    rows = [
        [f"`{f.topic}`", str(f.count), str(f.lost), f"{f.rate:.2f}", *(f"{age:.2f}" for age in f.ages)]
        for f in found
    ]  # fmt: skip
    whole = Load("all", sum(x.cpu for x in loads), sum(x.memory for x in loads))
    sizes = [[x.name, f"{x.cpu:.1f}", f"{x.memory:.0f}"] for x in (*loads, whole)]
    return Table(head, rows), Table(["process", "CPU, % of one core", "memory MB"], sizes)


def main() -> None:
    """Entry point: prints Markdown; exit status 1 when a message was lost after the warm-up."""
    p = OneLine(prog="er bench graph", description="Performance of the graph.")
    p.add_argument("--seconds", type=float, default=60.0, help="length of the run (60)")
    p.add_argument("--controller", action="store_true", help="with the Skyhook controller")
    options = p.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / "bag"
        try:
            loads = run(options.seconds, bag, controller=options.controller)
        except ErError as error:
            sys.stderr.write(f"er bench graph: {error}\n")
            sys.exit(error.exit_status)
        found = flows(bag)
    give((*tables(found, loads), machine()), None)
    sys.exit(1 if any(f.lost for f in found) else 0)


if __name__ == "__main__":
    main()
