"""kill -9 of each node of a running graph: the others go on, and it is back without anybody's help."""

from __future__ import annotations

import math
import signal
import sys
import tempfile
from pathlib import Path
from time import monotonic

import numpy as np
from er_studies.bench.machine import machine
from er_studies.given_out import Table, markdown

from test.reliability.graph import NODES, arguments, running, well
from test.reliability.hog import busy

WITHIN = 10.0
"""Longest time from the restart until the loop is well again [s]."""
LOOPS = 2
"""Busy loops beside the graph on a busy machine."""


def killed(times: int, folder: Path, within: float = WITHIN) -> dict[str, list[float]]:
    """For each node, from its restart until all is well [s]; inf where it was not within so long.

    Raises:
        AssertionError: Another node died, or impossible numbers went out.
    """
    found: dict[str, list[float]] = {name: [] for name in NODES}
    with running(folder) as (graph, nodes, listener):
        for _ in range(times):
            for name in NODES:
                nodes[name].process.send_signal(signal.SIGKILL)
                nodes[name].process.wait()
                listener.listen(0.3)
                others = [n for n in NODES if n != name]
                assert all(nodes[n].process.poll() is None for n in others), (
                    f"{name} took others along"
                )
                restarted = monotonic()
                nodes[name] = graph.start(name, *arguments(name))
                listener.nominal = listener.good = -math.inf
                back = listener.until(lambda: well(listener), within)
                found[name].append(monotonic() - restarted if math.isfinite(back) else math.inf)
                if math.isinf(back):
                    since = {t: monotonic() - last for t, last in listener.last.items()}
                    sys.stdout.write(f"{name} is not back: {since}, {listener.nominal}\n")
                    for each in nodes.values():
                        sys.stdout.write("".join(each.text.splitlines(keepends=True)[-4:]))
    assert listener.impossible == []
    return found


def run(times: int) -> int:
    """Print how soon each node was back, on a quiet machine and on a busy one; 1 where one was not."""
    head, rows = ["node", "busy loops", "kills", "back after, s p50", "p95", "longest"], []
    lasted = True
    for loops in (0, LOOPS):
        with tempfile.TemporaryDirectory() as folder, busy(loops):
            found = killed(times, Path(folder))
        for name, each in found.items():
            lasted = lasted and all(map(math.isfinite, each))
            late = np.percentile(each, (50, 95, 100), method="higher")
            rows.append([name, str(loops), str(len(each)), *(f"{t:.2f}" for t in late)])
    sys.stdout.write(f"{markdown(Table(head, rows))}\n{markdown(machine())}")
    return int(not lasted)
