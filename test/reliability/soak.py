"""A running graph for long, with a fault injected each minute: memory, losses, and what went out."""

from __future__ import annotations

import math
import sys
import tempfile
from pathlib import Path
from random import Random
from time import monotonic

from er_ros_common.injection import Kind
from er_studies.bench.graph import usage
from er_studies.bench.machine import machine
from er_studies.given_out import Table, markdown

from er_common import topics
from er_damper_msgs.srv import InjectFault
from test.reliability.graph import NUMBERS, Listener, running, well
from test.reliability.witness import Witness

MINUTE, LASTS, SETTLE = 60.0, 5.0, 0.5
"""A fault each so often, for so long, and the time after it until losses count [s]."""
SHORT = 12.0
"""A fault each so often in runs of less than ten minutes [s]."""
WARM = 60.0
"""Time until memory is looked at first [s]."""
GROWTH = 2.0
"""Most that a process may grow by [MB]."""
UNITS = (topics.ACCELERATION.name, topics.DEFLECTION.name, topics.PWM_COMMAND.name)
FAULTS = tuple(kind for kind in Kind if kind is not Kind.OK)
VALUES = {Kind.BIAS: 1.0, Kind.SLOW: 20.0, Kind.DELAYED: 0.1, Kind.INTERMITTENT: 0.5}


class Port:
    """The plant's service."""

    def __init__(self, listener: Listener) -> None:
        self.listener = listener
        self.client = listener.node.create_client(InjectFault, "/plant/inject_fault")

    def ask(self, unit: str, kind: Kind, duration: float) -> str:
        """Have a fault injected or taken away; what the plant says. Asked again where an answer is lost."""
        request = InjectFault.Request(unit=unit, duration=duration)
        request.kind, request.value = int(kind), VALUES.get(kind, 0.0)
        for _ in range(5):
            self.listener.until(self.client.service_is_ready, 5.0)
            answer = self.client.call_async(request)
            if math.isfinite(self.listener.until(answer.done, 2.0)):
                return str(answer.result().reason)
        return "no answer"


def run(seconds: int, priority: int = 0) -> int:
    """Print growth, losses outside the faults and what was impossible; 1 where anything was."""
    period = MINUTE if seconds > 10 * MINUTE else SHORT
    random, lost, count, unwell = Random(1), dict.fromkeys(NUMBERS, 0), 0, 0
    losses: list[float] = []
    with (
        tempfile.TemporaryDirectory() as folder,
        running(Path(folder), priority) as (_, nodes, listener),
        Witness() as witness,
    ):
        port, pids = Port(listener), {name: node.process.pid for name, node in nodes.items()}
        # what starts afresh is loaded when it is first needed: that is no growth
        for kind in FAULTS:
            port.ask(UNITS[0], kind, 1.0)
            listener.listen(1.5)
        listener.listen(min(WARM, seconds / 4))
        first, began = {name: memory(pid) for name, pid in pids.items()}, monotonic()
        while monotonic() - began < seconds:
            begun = monotonic()
            unit, kind = random.choice(UNITS), random.choice(FAULTS)
            said, count = port.ask(unit, kind, LASTS), count + 1
            listener.listen(LASTS)
            port.ask(unit, Kind.OK, 0.0)
            unwell += not math.isfinite(listener.until(lambda: well(listener), 3.0))
            listener.listen(SETTLE)
            before, refused = dict(listener.lost), sum(listener.refused.values())
            missed = len(listener.gaps)
            listener.listen(max(period - (monotonic() - begun), 0.0))
            gone = {name: listener.lost[name] - before[name] for name in lost}
            lost = {name: lost[name] + gone[name] for name in lost}
            losses += listener.gaps[missed:]
            witness.look()
            words = ", ".join(f"{name} {n}" for name, n in gone.items())
            old = sum(listener.refused.values()) - refused
            late = f"; too old when a node had them: {old}" if old else ""
            sys.stdout.write(f"{said}; lost after it: {words}{late}{listener.strangers()}\n")
            sys.stdout.flush()
        last = {name: memory(pid) for name, pid in pids.items()}
        alive = all(node.process.poll() is None for node in nodes.values())
        heard, impossible = sum(listener.count.values()), listener.impossible
        seen = witness.words(losses, began, monotonic())
    grown = {name: size - first[name] for name, size in last.items()}
    counts = ", ".join(f"{n} of `{name}`" for name, n in lost.items() if n) or "nothing"
    head = [
        "seconds",
        "faults",
        "messages",
        "lost outside the faults",
        f"growth of {', '.join(grown)}, MB",
    ]
    row = [
        str(seconds),
        str(count),
        str(heard),
        counts,
        ", ".join(f"{mb:.2f}" for mb in grown.values()),
    ]
    sys.stdout.write(markdown(Table(head, [row])) + "\n" + markdown(machine()) + "\n")
    sys.stdout.write(f"not well 3 s after a fault: {unwell}; impossible: {len(impossible)}\n")
    if not alive:
        sys.stdout.write("a node has ended\n")
    sys.stdout.write(f"{seen}\n")
    return int(
        any(mb > GROWTH for mb in grown.values())
        or any(lost.values())
        or bool(unwell)
        or bool(impossible)
        or not alive
    )


def memory(pid: int) -> float:
    """Resident memory of a process [MB]."""
    found = usage(pid)
    return found.memory / 1e6 if found else math.nan
