"""What was heard of a running graph in the last minutes: rows in one array, and what happened when."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from er_models.model import Array

from er_model_lab.live.join import COLUMNS, Row

PLACE = {name: k for k, name in enumerate(("t", *COLUMNS))}
CHANNELS = ("t", *COLUMNS[:6])
"""What the lab learns from."""
MINUTES = 5.0
"""How much of a drive is remembered [min]."""
RATE = 200.0
"""Rows a second for which there is room [Hz]."""
MARKS = 50
"""Most that is remembered of what happened."""
LEAST_STEP = 1e-6
"""Shortest time between two rows [s]."""


class Mark(NamedTuple):
    """Something that happened: when [s], and what."""

    t: float
    says: str


class Heard:
    """The last rows, oldest first; since: when the monitor took its model up [s]; marks: what happened.

    The array holds twice as many rows as are remembered, so that they lie together and are moved seldom.
    """

    def __init__(self, minutes: float = MINUTES) -> None:
        self.most = round(60.0 * minutes * RATE)
        self._kept = np.empty((2 * self.most, len(PLACE)))
        self.clear()

    def clear(self) -> None:
        """Forget everything: another drive begins."""
        self._end, self.since = 0, 0.0
        self.marks: deque[Mark] = deque(maxlen=MARKS)

    def add(self, rows: Sequence[Row]) -> None:
        """Keep rows, which follow those before."""
        part = np.array(rows[-self.most :], float).reshape(-1, len(PLACE))
        if self._end + len(part) > len(self._kept):
            left = self._kept[self._end - (self.most - len(part)) : self._end].copy()
            self._kept[: len(left)], self._end = left, len(left)
        self._kept[self._end : self._end + len(part)] = part
        self._end += len(part)

    @property
    def rows(self) -> Array:
        """The rows (n, 11), a view."""
        return self._kept[max(0, self._end - self.most) : self._end]

    @property
    def now(self) -> float:
        """Time of the last row [s]."""
        return float(self._kept[self._end - 1, 0]) if self._end else 0.0

    @property
    def seconds(self) -> float:
        """How much is remembered [s]."""
        return self.now - float(self.rows[0, 0]) if self._end else 0.0

    def last(self, seconds: float = np.inf, since: float = -np.inf) -> Array:
        """The rows of the last seconds, none of them before `since` [s]."""
        rows = self.rows
        return rows[np.searchsorted(rows[:, 0], max(self.now - seconds, since)) :]

    def column(self, name: str, seconds: float = np.inf, since: float = -np.inf) -> Array:
        """One column of these."""
        return self.last(seconds, since)[:, PLACE[name]]

    def mark(self, says: str) -> None:
        """Something happens now."""
        self.marks.append(Mark(self.now, says))

    def error(self, seconds: float = 5.0) -> float:
        """Rms of what is left in the last seconds, none before the model was taken up [N]; NaN where nothing is."""
        left = self.column("left", seconds, self.since)
        left = left[np.isfinite(left)]
        return float(np.sqrt(np.mean(left**2))) if left.size else np.nan

    def said(self, name: str) -> float:
        """What the monitor said last of `usual`, `ratio` or `status`; NaN where it was silent."""
        values = self.column(name, 1.0)
        values = values[np.isfinite(values)]
        return float(values[-1]) if values.size else np.nan

    def began(self) -> float:
        """When the sum of the test was zero last: what it says now began there [s]."""
        t, ratio = self.column("t", since=self.since), self.column("ratio", since=self.since)
        rest = np.flatnonzero(ratio <= 0.0)
        return float(t[rest[-1]]) if rest.size else self.since

    def channels(self, since: float = -np.inf) -> dict[str, Array]:
        """Channels (n,) by the lab's names, of rows that have a motion, from one that has all channels on.

        Those that never came are left out.
        """
        rows = self.last(since=since)
        rows = rows[np.isfinite(rows[:, PLACE["deflection"]])]
        rows = rows[np.diff(rows[:, 0], prepend=-np.inf) > LEAST_STEP]
        found = {name: rows[:, PLACE[name]].copy() for name in CHANNELS}
        found = {name: y for name, y in found.items() if np.isfinite(y).any()}
        whole = (
            np.logical_and.reduce([np.isfinite(y) for y in found.values()])
            if found
            else np.zeros(0)
        )
        first = int(np.argmax(whole)) if whole.any() else 0
        return {name: y[first:] for name, y in found.items()}
