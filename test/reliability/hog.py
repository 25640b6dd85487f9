"""Two busy loops beside a running graph: the newest sample is used, nothing queues up, and it recovers."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from er_studies.bench.machine import machine
from er_studies.given_out import markdown

from test.reliability.graph import running, well

LOOP = "while True: pass"


@contextmanager
def busy(loops: int) -> Iterator[None]:
    """So many busy loops beside the block, without any priority of ours."""
    command = ["chrt", "--other", "0", sys.executable, "-I", "-c", LOOP]
    hogs = [subprocess.Popen(command) for _ in range(loops)]
    try:
        yield
    finally:
        for hog in hogs:
            hog.kill()
            hog.wait()


def run(seconds: int, priority: int = 0) -> int:
    """Print the ages of the applied duty before, during and after; 1 where it does not recover."""
    with (
        tempfile.TemporaryDirectory() as folder,
        running(Path(folder), priority) as (_, _, listener),
    ):
        listener.ages.clear()
        listener.listen(seconds)
        before, listener.ages = listener.ages, []
        with busy(2):
            listener.listen(seconds)
        during, listener.ages = listener.ages, []
        back = listener.until(lambda: well(listener), 5.0)
        listener.listen(seconds)
        after = listener.ages
    sys.stdout.write("| | messages | age ms p50 | p99 | max |\n|---|---|---|---|---|\n")
    for name, ages in (("before", before), ("during", during), ("after", after)):
        p50, p99, most = (1e3 * float(np.percentile(ages, p)) for p in (50, 99, 100))
        sys.stdout.write(f"| {name} | {len(ages)} | {p50:.2f} | {p99:.2f} | {most:.2f} |\n")
    sys.stdout.write(f"\n{markdown(machine())}")
    sys.stdout.write(f"well {back:.2f} s after the end\n")
    return int(not back <= 1.0)
