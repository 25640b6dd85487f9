"""Joins what belongs to one tick: accelerations, deflection, the duty from then on, a force where one is used. Pure.

A tick is given on when it is complete, or, with NaN for what is missing, when a later one is or too many wait.
ARCHITECTURE.md compares this with the other two ways to join a tick.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

from er_common.stamps import SECOND, StampLimits

DEPTH = 4
"""Ticks that may wait for a part."""
ACCELERATION, DEFLECTION, DUTY, FORCE = range(4)
"""Parts of a tick."""
BACK = round(StampLimits().back * SECOND)
"""Step back of the accelerations' stamps that is a jump of time, not a straggler [ns].

Seen from the last tick given on, which may be later than the last accelerations: they may have been silent before.
"""

Part = tuple[float, ...]


class Tick(NamedTuple):
    """Parts of a stamp [ns] that have come, None for the others; sequence number."""

    stamp: int
    seq: int
    parts: tuple[Part | None, Part | None, Part | None, Part | None] = (None,) * 4


class Gathered(NamedTuple):
    """Ticks that wait, by stamp; the last stamp given on; parts that were missing."""

    waiting: Mapping[int, Tick] = MappingProxyType({})
    last: int = 0
    missing: int = 0


def add(
    gathered: Gathered, needed: tuple[int, ...], which: int, stamp: int, seq: int, part: Part
) -> tuple[Gathered, list[Tick]]:
    """Take a part (two accelerations, deflection and velocity, a duty, a force); the ticks that can go on, in order.

    needed: parts that a complete tick has. A part of a tick that was given on changes nothing. Time is that of the
    accelerations: where they jump back, what waits is of another past; another part that is old is only old.
    """
    if stamp <= gathered.last:
        if which != ACCELERATION or gathered.last - stamp <= BACK:
            return gathered, []
        gathered = Gathered(missing=gathered.missing)
    _, seq, before = gathered.waiting.get(stamp) or Tick(stamp, seq)
    parts = (*before[:which], part, *before[which + 1 :])
    waiting = {**gathered.waiting, stamp: Tick(stamp, seq, parts)}  # type: ignore[arg-type]
    complete = None not in [parts[i] for i in needed]
    if not complete and len(waiting) <= DEPTH:
        return Gathered(waiting, gathered.last, gathered.missing), []
    order = sorted(waiting)
    # what is complete has never waited
    until = stamp if complete else order[-DEPTH - 1]
    ready = [waiting[s] for s in order if s <= until]
    lost = sum(t.parts[i] is None for t in ready for i in needed)
    left = {s: t for s, t in waiting.items() if s > until}
    return Gathered(left, until, gathered.missing + lost), ready
