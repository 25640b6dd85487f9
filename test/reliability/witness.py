"""Hold-ups of the machine itself: on each core a process of the highest priority that wants to run each millisecond.

Where it comes late nothing of ours can be the cause: the core itself stood still, or the system's own work had it.

python -m test.reliability.witness CORE       prints when it should have run and how late it was, until it is ended
"""

from __future__ import annotations

import gc
import os
import subprocess
import sys
from collections.abc import Sequence
from time import monotonic, sleep
from types import TracebackType

STEP, LATE = 1e-3, 5e-3
"""How often it wants to run, and from what lateness on it says so [s]."""
AFTER = 0.1
"""Time after a hold-up within which a loss may come from it [s]."""
HIGHEST = os.sched_get_priority_max(os.SCHED_FIFO)


def watch(core: int) -> None:
    """Say each hold-up of a core, for ever."""
    os.sched_setaffinity(0, {core})
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(HIGHEST))
    gc.disable()
    while True:
        due = monotonic() + STEP
        sleep(STEP)
        late = monotonic() - due
        if late > LATE:
            sys.stdout.write(f"{due} {late}\n")
            sys.stdout.flush()


class Witness:
    """Watches all cores; hold-ups: when each began, and how long it was [s]."""

    def __init__(self) -> None:
        self.hold_ups: list[tuple[float, float]] = []
        command = [sys.executable, "-m", "test.reliability.witness"]
        self.processes = [
            subprocess.Popen(
                [*command, str(core)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
            )
            for core in sorted(os.sched_getaffinity(0))
        ]

    def __enter__(self) -> Witness:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:  # fmt: skip
        for process in self.processes:
            process.kill()
            process.wait()

    def look(self) -> None:
        """Take over what was said since the last look."""
        for process in self.processes:
            for line in _said(process):
                begun, late = map(float, line.split())
                self.hold_ups.append((begun, late))

    def explains(self, when: float) -> float:
        """Longest hold-up [s] that ended less than `AFTER` before a time, or was on at it; 0 for none."""
        near = [late for begun, late in self.hold_ups if begun <= when <= begun + late + AFTER]
        return max(near, default=0.0)

    def chance(self, began: float, ended: float) -> float:
        """Share of a time that lies in or soon after a hold-up: what would be explained by chance."""
        covered, until = 0.0, began
        for begun, late in sorted(self.hold_ups):
            end = min(begun + late + AFTER, ended)
            covered += max(end - max(begun, until), 0.0)
            until = max(until, end)
        return covered / (ended - began)

    def words(self, losses: Sequence[float], began: float, ended: float) -> str:
        """What it has seen, beside when something was lost."""
        self.look()
        if any(process.poll() is not None for process in self.processes):
            return "no witness of hold-ups: real-time priority is not allowed here"
        own = [self.explains(when) for when in losses]
        longest = max((late for _, late in self.hold_ups), default=0.0)
        return (
            f"cores held up for more than {1e3 * LATE:g} ms: {len(self.hold_ups)} times, "
            f"at most {1e3 * longest:.0f} ms; "
            f"losses within {AFTER:g} s of that: {sum(late > 0.0 for late in own)} of {len(losses)} "
            f"({100.0 * self.chance(began, ended):.2g} % by chance)"
        )


def _said(process: subprocess.Popen[bytes]) -> list[bytes]:
    """Lines that wait in its pipe; each is written at once."""
    if process.stdout is None:
        return []
    os.set_blocking(process.stdout.fileno(), False)
    return (process.stdout.read() or b"").splitlines()


if __name__ == "__main__":
    watch(int(sys.argv[1]))
