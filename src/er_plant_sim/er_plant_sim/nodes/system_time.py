"""The system's time of an instant on the steady clock, also after the system clock was set."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic_ns, time_ns

from er_common.stamps import CLOCK_STEP

READINGS = 3


def difference() -> int:
    """System time less steady time [ns]; of several readings that which was held up least."""
    found = []
    for _ in range(READINGS):
        before, system = monotonic_ns(), time_ns()
        found.append((monotonic_ns() - before, system - before))
    return min(found)[1]


class SystemTime:
    """Turns instants of the steady clock into stamps: not moved by small corrections, at once by a jump."""

    def __init__(self, measured: Callable[[], int] = difference) -> None:
        self._measured = measured
        self._offset, self.steps = measured(), 0

    def stamp(self, steady: int) -> int:
        """System time of an instant on the steady clock [ns]."""
        return steady + self._offset

    def follow(self) -> None:
        """Notice a system clock that was set."""
        offset = self._measured()
        if abs(offset - self._offset) > CLOCK_STEP:
            self._offset, self.steps = offset, self.steps + 1
