"""Cost of the running graph: loop latency, lateness, losses, processor time, beside plain rclpy executors.

    er bench ros                       200 Hz, six processes and composed, each with both executors: 4 x 60 s
    er bench ros --rate 1000 --layout composed
    er bench ros --corners 4 --layout processes --executor events --transport udp,shm

Every layout runs under the events executor of this project and under the single-threaded one, which is what
rclpy.spin uses, in the same run: ratios hold where the machine is busy, latencies do not. What else the machine did
meanwhile is measured and said. The loop goes from a sample at the plant through the controller back to the plant.
Of several corners the worst is told. Exit status 1 when samples were lost, or an aim or a ratio missed, on a quiet
machine.
"""

from __future__ import annotations

import argparse
import io
import os
import platform
import re
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from time import monotonic, sleep

import numpy as np
from er_bringup.given import complete
from er_bringup.graph import ComposedSpec, NodeSpec, ends_all, nodes
from er_bringup.processes import Child, stop
from er_bringup.programs import CONTROLLERS, EVERY
from er_bringup.up import argv, configuration
from er_models.constants import SAMPLE_RATE
from er_models.errors import ErError
from er_models.one_line import OneLine
from er_plant_sim.programs import PLANT

from er_studies import given_out
from er_studies.bench.graph import Load, Usage, usage
from er_studies.bench.machine import machine
from er_studies.bench.ros_transport import TRANSPORTS, UDP, take
from er_studies.given_out import Table

LAYOUTS = ("processes", "composed")
EXECUTORS = ("events", "single")
QUIET = 10.0
"""Most that other programs may use of the machine for latencies to mean anything [%]."""
NAP = 0.02
PACED = (PLANT.name, *(program.name for program in EVERY if program.rate))
"""Who is told the rate."""
START = 120.0
"""Longest time from the start of the processes to the first tick [s]."""
_NUMBERS = r"p50 ([\d.]+), p99 ([\d.]+), p99.9 ([\d.]+), max ([\d.]+)"
_LINE = re.compile(rf"loop ms {_NUMBERS}; lateness ms {_NUMBERS}; unanswered (\d+) of (\d+)")
TARGETS = {
    ("processes", 200.0): (1.5, 3.0, 5.0, 45.0),
    ("composed", 200.0): (0.4, 1.0, 3.0, 12.0),
    ("composed", 1000.0): (0.3, 0.8, 3.0, 35.0),
}
"""Aims on a quiet machine: loop latency p50, p99, p99.9 [ms], processor time [% of a core]."""
AIMS = ("loop p50, ms", "p99, ms", "p99.9, ms", "CPU, % of a core")
"""What the aims are of."""
RATIOS = {"processes": 2.7, "composed": 6.0}
"""How many times the processor time of ours plain rclpy uses at 200 Hz, at least."""


@dataclass(frozen=True)
class Result:
    """One run: loop latency and lateness p50, p99, p99.9, max [ms], samples and unanswered ones, load per process.

    others: what other programs used of the whole machine [%]; woke: lateness of a sleeping process, p99 [ms].
    """

    layout: str
    executor: str
    loop: tuple[float, ...]
    lateness: tuple[float, ...]
    lost: int
    ticks: int
    loads: tuple[Load, ...]
    others: float
    woke: float
    transport: str = UDP
    corners: int = 1

    @property
    def cpu(self) -> float:
        """Processor time of all processes [% of a core]."""
        return sum(load.cpu for load in self.loads)


def specs(
    layout: str, executor: str, seconds: float, rate: float, controller: str, corners: int = 1
) -> tuple[NodeSpec, ...]:
    """The processes of one run; several corners are below one namespace."""
    given = {
        "duration": str(seconds),
        "controller": controller,
        "fault_estimator": "true",
        "composed": str(layout == "composed").lower(),
    }
    if corners > 1:
        given["corners"] = ",".join(f"corner_{k}" for k in range(corners))
    return tuple(_with(spec, executor, rate) for spec in nodes(complete(given), configuration()))


def _with(spec: NodeSpec, executor: str, rate: float) -> NodeSpec:
    if isinstance(spec, ComposedSpec):
        return replace(spec, parts=tuple(_with(part, executor, rate) for part in spec.parts))
    own = {"rate": rate} if spec.executable in PACED else {}
    return replace(spec, parameters={**spec.parameters, "executor": executor, **own})


def run(
    layout: str,
    executor: str,
    transport: str,
    seconds: float,
    rate: float,
    controller: str,
    corners: int,
) -> Result:
    """One run, by the transport that the environment already has.

    Raises:
        ErError: A plant ended without saying how it went.
    """
    out = io.StringIO()
    each = specs(layout, executor, seconds, rate, controller, corners)
    children = [Child(spec.label, argv(spec), out) for spec in each]
    plants = [child for spec, child in zip(each, children, strict=True) if ends_all(spec)]
    try:
        _wait_for(out, plants)
        loads, others, woke = _measured(children, plants)
    finally:
        stop(children)
    found = np.array([[float(word) for word in line] for line in _LINE.findall(out.getvalue())])
    if len(found) < corners:
        lines = out.getvalue().strip().splitlines()
        raise ErError(f"{layout}, {executor}: {lines[-1] if lines else 'nothing was said'}")
    worst, (lost, ticks) = (
        found.max(axis=0).tolist(),
        found[:, 8:].sum(axis=0).astype(int).tolist(),
    )
    loop, late = tuple(worst[:4]), tuple(worst[4:8])
    return Result(
        layout, executor, loop, late, lost, ticks, tuple(loads), others, woke, transport, corners
    )


def _wait_for(out: io.StringIO, plants: Sequence[Child]) -> None:
    """Wait for the first tick of each."""
    until = monotonic() + START
    while out.getvalue().count("plant]: running") < len(plants):
        if any(plant.status is not None for plant in plants) or monotonic() > until:
            said = [line for line in out.getvalue().splitlines() if "plant" in line]
            raise ErError(f"the plant did not begin: {said[-1] if said else 'it said nothing'}")
        sleep(NAP)


def _measured(
    children: Sequence[Child], plants: Sequence[Child]
) -> tuple[list[Load], float, float]:
    """Load of the processes, that of others, and how late we wake [ms], until the first plant ends."""
    began, machine = monotonic(), _busy()
    before = {c.label: usage(c.process.pid) for c in children}
    after, late = dict(before), []
    total = machine
    while all(plant.status is None for plant in plants):
        asleep = monotonic()
        sleep(NAP)
        late.append(monotonic() - asleep - NAP)
        if len(late) % 10 == 0:
            now = {c.label: usage(c.process.pid) for c in children}
            if all(each is not None for each in now.values()):
                after, total, elapsed = now, _busy(), monotonic() - began
    loads = [_load(label, before[label], after[label], elapsed) for label in before]
    ours = sum(load.cpu for load in loads) / 100.0 * elapsed
    everything = (os.cpu_count() or 1) * elapsed
    others = 100.0 * max(total - machine - ours, 0.0) / everything
    return loads, others, 1e3 * float(np.percentile(late, 99.0))


def _load(label: str, first: Usage | None, last: Usage | None, elapsed: float) -> Load:
    if first is None or last is None:
        return Load(label, 0.0, 0.0)
    return Load(label, 100.0 * (last.cpu - first.cpu) / elapsed, last.memory / 1e6)


def _busy() -> float:
    """Processor time of the whole machine that was not idle [s], from an arbitrary time on.

    Idle time is measured, what is busy is counted where a tick of the clock finds it: a loop of 1 kHz keeps step with
    that, and was found always or never.
    """
    words = Path("/proc/stat").read_text(encoding="ascii").splitlines()[0].split()[1:]
    idle = (int(words[3]) + int(words[4])) / os.sysconf("SC_CLK_TCK")
    return (os.cpu_count() or 1) * monotonic() - idle


def markdown(results: Sequence[Result], seconds: float, rate: float) -> str:
    """The figures as tables, and what they are worth."""
    host = f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}"
    tables = [costs(results), processes(results), beside(results, rate), against(results, rate)]
    lines = [given_out.markdown(each) for each in tables if each.rows]
    return "\n".join([f"{seconds:g} s at {rate:g} Hz each; {host}\n", *lines, *noisy(results)])


def costs(results: Sequence[Result]) -> Table:
    """Every run by itself."""
    head = [
        "layout", "executor", "transport", "loop ms p50", "p99", "p99.9", "max", "lateness ms p50", "p99",
        "CPU, % of a core", "lost", "others, % of the machine", "asleep too long, ms p99",
    ]  # fmt: skip
    rows = [
        [
            r.layout, r.executor, r.transport, *(f"{x:.2f}" for x in (*r.loop, *r.lateness[:2])),
            f"{r.cpu:.1f}", f"{r.lost} of {r.ticks}", f"{r.others:.0f}", f"{r.woke:.2f}",
        ]
        for r in results
    ]  # fmt: skip
    return Table(head, rows)


def processes(results: Sequence[Result]) -> Table:
    """The load of every process."""
    rows = [
        [each.name, r.layout, r.executor, r.transport, f"{each.cpu:.1f}", f"{each.memory:.0f}"]
        for r in results
        for each in r.loads
    ]
    head = ["process", "layout", "executor", "transport", "CPU, % of a core", "memory MB"]
    return Table(head, rows)


def pairs(results: Sequence[Result]) -> list[tuple[Result, Result]]:
    """Ours and plain rclpy of each layout, both over the same transport."""
    plain = {(r.layout, r.transport): r for r in results if r.executor == "single"}
    ours = (r for r in results if r.executor == "events")
    return [(r, plain[r.layout, r.transport]) for r in ours if (r.layout, r.transport) in plain]


def beside(results: Sequence[Result], rate: float) -> Table:
    """What plain rclpy costs over ours."""
    asked = {
        name: f" (at least {r:g})" if rate == SAMPLE_RATE else "" for name, r in RATIOS.items()
    }
    rows = [
        [
            ours.layout, ours.transport, f"{plain.cpu / ours.cpu:.2f}{asked[ours.layout]}",
            f"{plain.loop[0] / max(ours.loop[0], 1e-9):.1f}", f"{plain.lost} of {plain.ticks}",
        ]
        for ours, plain in pairs(results)
    ]  # fmt: skip
    head = [
        "plain rclpy over ours",
        "transport",
        "processor time",
        "loop p50",
        "lost by plain rclpy",
    ]
    return Table(head, rows)


def against(results: Sequence[Result], rate: float) -> Table:
    """What was found of the aims."""
    rows = [
        [
            r.layout,
            *(f"{found:.2f} of {aim:g}" for found, aim in zip(_found(r), aims, strict=True)),
        ]
        for r in results
        if r.executor == "events" and (aims := _aims(r, rate))
    ]
    return Table(["aims", *AIMS], rows)


def noisy(results: Sequence[Result]) -> list[str]:
    """Which runs are worth nothing, as the machine was busy."""
    return [
        f"{r.layout}, {r.executor}: too noisy to judge latencies: others used {r.others:.0f} % of the machine"
        for r in results
        if r.others > QUIET
    ]


def _aims(r: Result, rate: float) -> tuple[float, ...]:
    """The aims of a layout at a rate; none where there are none."""
    return TARGETS.get((r.layout, rate), ()) if r.corners == 1 else ()


def _found(r: Result) -> tuple[float, ...]:
    """What stands beside the aims."""
    return (*r.loop[:3], r.cpu)


def failed(results: Sequence[Result], rate: float) -> bool:
    """Whether ours lost a sample, or missed an aim or a ratio, on a quiet machine."""
    for r in results:
        if r.executor != "events" or r.others > QUIET:
            continue
        if r.lost or any(f > aim for f, aim in zip(_found(r), _aims(r, rate), strict=False)):
            return True
    return rate == SAMPLE_RATE and any(_short(*pair) for pair in pairs(results))


def _short(ours: Result, plain: Result) -> bool:
    """Whether plain rclpy used less than it should beside ours; one that lost samples did not do all of the work."""
    judged = max(ours.others, plain.others) <= QUIET and ours.corners == 1 and not plain.lost
    return judged and plain.cpu < RATIOS[ours.layout] * ours.cpu


def transports(text: str) -> tuple[str, ...]:
    """The names of an option."""
    names = tuple(text.split(","))
    if not {*names} <= {*TRANSPORTS}:
        raise argparse.ArgumentTypeError(f"expected some of {','.join(TRANSPORTS)}, not '{text}'")
    return names


def parser() -> argparse.ArgumentParser:
    """Options of the command."""
    p = OneLine(prog="er bench ros", description=(__doc__ or "").split("\n")[0])
    p.add_argument("--seconds", type=float, default=60.0, help="length of each run (60)")
    p.add_argument("--rate", type=float, default=200.0, help="ticks per second (200)")
    p.add_argument("--layout", choices=(*LAYOUTS, "both"), default="both")
    p.add_argument("--executor", choices=(*EXECUTORS, "both"), default="both")
    p.add_argument("--corners", type=int, default=1, help="corners of a car, each a graph (1)")
    p.add_argument(
        "--transport",
        type=transports,
        default=(UDP,),
        help="between processes: udp (default), shm, or udp,shm",
    )
    p.add_argument("--controller", choices=tuple(CONTROLLERS), default="ftc")
    return p


def main() -> None:
    """Entry point of the command."""
    o = parser().parse_args()
    layouts = LAYOUTS if o.layout == "both" else (o.layout,)
    executors = EXECUTORS if o.executor == "both" else (o.executor,)
    with tempfile.TemporaryDirectory() as folder:
        os.environ["ROS_LOG_DIR"] = folder
        results = []
        try:
            for layout, transport, executor in product(layouts, o.transport, executors):
                take(transport, Path(folder))
                given = (o.seconds, o.rate, o.controller, o.corners)
                results.append(run(layout, executor, transport, *given))
        except ErError as error:
            sys.stderr.write(f"er bench ros: {error}\n")
            sys.exit(error.exit_status)
    here = given_out.markdown(machine())
    sys.stdout.write(f"{markdown(results, o.seconds, o.rate)}\n\n{here}")
    sys.exit(1 if failed(results, o.rate) else 0)


if __name__ == "__main__":
    main()
