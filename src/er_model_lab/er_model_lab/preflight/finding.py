"""One thing that was checked: how it is, and what to do where it is wrong."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Level = Literal["ok", "note", "warning", "fail"]
ORDER: dict[str, int] = {"fail": 0, "warning": 1, "note": 2, "ok": 3}
"""Worst first."""
Spans = tuple[tuple[float, float], ...]
"""From when to when, in the time of a record [s]."""
MOST = 200
"""Spans of a finding: of more, near ones are joined."""


@dataclass(frozen=True)
class Finding:
    """A check of one record.

    check: channels, sampling, dropouts, held, clipping, spikes, ends, units, clock, bias, power, motion, records or
    size; channel: the one concerned, or empty; expected and found: as an error says them; remedy: what to do; a finding
    of level `fail` stops a command; spans: where it is in the record, empty where it is of the whole.
    """

    check: str
    level: Level
    record: str
    channel: str
    expected: str
    found: str
    remedy: str = ""
    source: str = ""
    spans: Spans = ()

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return {k: v for k, v in asdict(self).items() if k != "source"}


def spans_of(t: NDArray[np.float64], mask: NDArray[np.bool_]) -> Spans:
    """Where a mask (n,) holds, in the times t (n,) [s]."""
    edges = np.flatnonzero(np.diff(mask, prepend=False, append=False)).reshape(-1, 2)
    return joined([(t[i], t[j - 1]) for i, j in edges])


def joined(spans: Sequence[tuple[float, float]]) -> Spans:
    """Spans in their order [s], at most `MOST`: of more, those that are nearest to one another are one."""
    each = np.asarray(spans, float).reshape(-1, 2)
    if len(each) > MOST:
        apart = np.sort(np.argsort(each[:-1, 1] - each[1:, 0], kind="stable")[: MOST - 1])
        first, last = np.append(0, apart + 1), np.append(apart, len(each) - 1)
        each = np.stack([each[first, 0], each[last, 1]], axis=1)
    return tuple((float(a), float(b)) for a, b in each)
