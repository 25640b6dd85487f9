"""When ticks are due: an absolute schedule on a steady clock, so that no error adds up.

``due(p, state, now) -> (state, ticks)``. A little lateness is made up by running the missed ticks
at once; after a long stop (a suspended machine) the schedule starts anew and the gap is reported
as skipped ticks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple


@dataclass(frozen=True)
class Schedule:
    """Period [ns] of the clock the schedule runs on, and how many missed ticks are made up."""

    period: int
    catch_up: int = 20


class Progress(NamedTuple):
    """Start of the schedule [ns], ticks done since then, and ticks given up so far."""

    start: int
    done: int = 0
    skipped: int = 0


def due(p: Schedule, state: Progress, now: int) -> tuple[Progress, int]:
    """Ticks to run at time now [ns]; tick n (from 0) is due at start + n * period."""
    ticks = (now - state.start) // p.period + 1 - state.done
    if ticks <= 0:
        return state, 0
    if ticks > p.catch_up:
        skipped = ticks - 1
        return Progress(state.start, state.done + skipped + 1, state.skipped + skipped), 1
    return state._replace(done=state.done + ticks), int(ticks)


def next_due(p: Schedule, state: Progress) -> int:
    """Time of the next tick [ns]."""
    return state.start + state.done * p.period
