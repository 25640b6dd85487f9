"""Joins what several topics say of one instant to a row; what is lost is NaN. Pure."""

from __future__ import annotations

import math
from bisect import bisect_left, insort

COLUMNS = (
    "sprung_acceleration", "unsprung_acceleration", "deflection", "deflection_velocity", "duty", "damper_force",
    "left", "usual", "ratio", "status",
)  # fmt: skip
"""Of a row, behind its time: channels of the lab, then what a monitor says of the model.

left: measured less predicted force [N]; usual: the size that it should have [N]; ratio: of the test over its limit [1];
status: one of `DamperForce.STATUS_*`.
"""
WAIT = 100_000_000
"""How far behind the newest stamp a row waits for what it lacks [ns]."""
BACK = 1_000_000_000
"""Step back of the stamps that is another drive, not a straggler [ns]."""
GAP = 5_000_000_000
"""Step forward of the stamps that is another drive, not a loss [ns]."""
ANEW = 200
"""Step back of the sequence numbers of a topic that is another drive, not a straggler."""

Row = tuple[float, ...]
"""Time since the first stamp [s], then `COLUMNS`."""


class Join:
    """Rows by their stamps; again: how often another drive began; numbers: the last one of each column's topic."""

    def __init__(self) -> None:
        self.rows: dict[int, list[float]] = {}
        self.order: list[int] = []
        self.numbers: dict[int, int] = {}
        self.first, self.given, self.again = 0, -1, 0

    def add(self, stamp: int, column: int, values: tuple[float, ...], number: int = 0) -> None:
        """Put values of a stamp [ns] into a row, from a column on; one that was given on already gets no more.

        number: sequence number of the message, 0 where it is unknown. A graph that was started again counts from the
        beginning, however soon that was.
        """
        last = self.numbers.get(column)
        if last is not None and (self.given - stamp > BACK or 0 < number < last - ANEW):
            self._begin_again(stamp)
        if stamp <= self.given:
            return
        self.numbers[column] = number
        row = self.rows.get(stamp)
        if row is None:
            row = self.rows[stamp] = [math.nan] * len(COLUMNS)
            insort(self.order, stamp)
            self.first = self.first or stamp
        row[column : column + len(values)] = values

    def _begin_again(self, stamp: int) -> None:
        """Another drive, with this stamp first: what the one before still says comes too late."""
        again = self.again + 1
        Join.__init__(self)
        self.given, self.again = stamp - 1, again

    def ready(self) -> list[Row]:
        """Rows that wait for nothing any more, in order."""
        if not self.order:
            return []
        many = bisect_left(self.order, self.order[-1] - WAIT)
        ready, self.order = self.order[:many], self.order[many:]
        begin = 0  # where another drive begins; what is left of the one before is dropped
        for k, (last, stamp) in enumerate(zip((self.given, *ready), ready, strict=False)):
            if 0 <= last < stamp - GAP:
                begin, self.first, self.again = k, stamp, self.again + 1
        self.given = ready[-1] if ready else self.given
        rows = [(1e-9 * (s - self.first), *self.rows.pop(s)) for s in ready]
        return rows[begin:]
