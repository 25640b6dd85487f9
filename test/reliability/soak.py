"""A running graph for long, with a fault injected each minute: memory, losses, and what went out."""

from __future__ import annotations

import math
import sys
import tempfile
from pathlib import Path
from random import Random
from time import monotonic

from er_bringup.bench_graph import usage
from er_ros_common.injection import Kind

from er_damper_msgs.srv import InjectFault
from er_ros_common import topics
from test.reliability.graph import NUMBERS, Listener, running, well

MINUTE, LASTS = 60.0, 5.0
"""A fault each so often, for so long [s]."""
WARM = 60.0
"""Time until memory is looked at first [s]."""
GROWTH = 2.0
"""Most that a process may grow by [MB]."""
UNITS = (topics.ACCELERATION.name, topics.DEFLECTION.name, topics.PWM_COMMAND.name)
VALUES = {Kind.BIAS: 1.0, Kind.SLOW: 20.0, Kind.DELAYED: 0.1, Kind.INTERMITTENT: 0.5}


def inject(listener: Listener, random: Random) -> str:
    """Have any fault injected; what the plant says of it."""
    client = listener.node.create_client(InjectFault, "/plant/inject_fault")
    kind = random.choice([k for k in Kind if k is not Kind.OK])
    request = InjectFault.Request(unit=random.choice(UNITS), duration=LASTS)
    request.kind, request.value = int(kind), VALUES.get(kind, 0.0)
    listener.until(client.service_is_ready, 5.0)
    answer = client.call_async(request)
    listener.until(answer.done, 5.0)
    listener.node.destroy_client(client)
    return str(answer.result().reason) if answer.done() else "no answer"


def run(seconds: int) -> int:
    """Print growth, losses outside the faults and what was impossible; 1 where anything was."""
    random, faults = Random(1), []
    lost = dict.fromkeys(NUMBERS, 0)
    with tempfile.TemporaryDirectory() as folder, running(Path(folder)) as (_, nodes, listener):
        began = monotonic()
        pids = {name: node.process.pid for name, node in nodes.items()}
        listener.listen(min(WARM, seconds / 4))
        first = {name: memory(pid) for name, pid in pids.items()}
        unwell = 0
        while monotonic() - began < seconds:
            faults.append(inject(listener, random))
            listener.listen(LASTS)
            unwell += not math.isfinite(listener.until(lambda: well(listener), 3.0))
            before = dict(listener.lost)
            listener.listen(max(MINUTE - LASTS - 3.0, 0.0))
            for name in lost:
                lost[name] += listener.lost[name] - before[name]
        last = {name: memory(pid) for name, pid in pids.items()}
        alive = all(node.process.poll() is None for node in nodes.values())
        count, impossible = sum(listener.count.values()), listener.impossible
    sys.stdout.write(f"{seconds} s, {len(faults)} faults, {count} messages heard\n")
    for name, size in last.items():
        sys.stdout.write(f"{name}: {first[name]:.1f} MB, {size - first[name]:+.2f} MB since\n")
    words = ", ".join(f"{name} {n}" for name, n in lost.items())
    said = f"lost outside the faults: {words}; not well 3 s after a fault: {unwell}; impossible: {len(impossible)}"
    sys.stdout.write(f"{said}; all alive: {alive}\n")
    grown = any(size - first[name] > GROWTH for name, size in last.items())
    return int(grown or any(lost.values()) or bool(unwell) or bool(impossible) or not alive)


def memory(pid: int) -> float:
    """Resident memory of a process [MB]."""
    found = usage(pid)
    return found.memory / 1e6 if found else math.nan
