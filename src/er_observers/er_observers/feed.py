"""Joins accelerations with the duty applied from then on, and a deflection where one is used. Pure.

Duty and deflection of a tick are published after its accelerations. Where one has not come before the
accelerations of the next tick, these are given on with NaN in its place: a lost part holds nothing up. The
observers take NaN as duty for "as before", and bridge a sample whose deflection they need and do not have.
A deflection that they can do without is waited for only while it comes: the tick after a lost one goes on with
accelerations and duty.
ARCHITECTURE.md compares this with the other two ways to join a tick.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

DEPTH = 10
"""Duties, and deflections, kept that are ahead of their accelerations."""
_Parts = Mapping[int, float]
_NONE: _Parts = MappingProxyType({})


class Motion(NamedTuple):
    """Accelerations [m/s2] of a tick: stamp [ns], sequence number, sprung, unsprung."""

    stamp: int
    seq: int
    sprung: float
    unsprung: float


class Joined(NamedTuple):
    """Accelerations, the duty from then on, the deflection [m]; NaN where one was lost or is not used."""

    motion: Motion
    duty: float
    deflection: float = math.nan


class Feed(NamedTuple):
    """Accelerations that wait for other parts, and parts that wait for them, by stamp [ns].

    deflections: None where none are used; lost, blind: duties and deflections that did not come in time;
    needed: whether a tick always waits for its deflection, else only where that of the tick before came;
    came: whether it did.
    """

    waiting: Motion | None = None
    duties: _Parts = _NONE
    deflections: _Parts | None = None
    lost: int = 0
    blind: int = 0
    needed: bool = False
    came: bool = False


def feed_of(*, deflection: bool, needed: bool = True) -> Feed:
    """Before any message; deflection: whether a tick has one; needed: whether it always waits for it."""
    return Feed(deflections=_NONE if deflection else None, needed=needed)


def on_motion(feed: Feed, motion: Motion) -> tuple[Feed, list[Joined]]:
    """Take accelerations; what can be given on now, oldest first."""
    ready = []
    if feed.waiting is not None:
        ready.append(_joined(feed, feed.waiting))
        stamp, seen = feed.waiting.stamp, feed.deflections
        blind = seen is not None and stamp not in seen
        feed = feed._replace(
            lost=feed.lost + (stamp not in feed.duties),
            blind=feed.blind + blind,
            came=feed.came and not blind,
        )
    _, duties, seen, lost, missed, needed, came = feed
    return _given_on(Feed(motion, duties, seen, lost, missed, needed, came), ready)


def on_duty(
    feed: Feed, stamp: int, duty: float, *, back: bool = False
) -> tuple[Feed, list[Joined]]:
    """Take a duty; the accelerations it completes. back: time has jumped back, those kept are of another past."""
    waiting, duties, seen, lost, blind, needed, came = feed
    if waiting is not None and waiting.stamp == stamp and not duties and seen is None:
        return Feed(None, _NONE, None, lost, blind, needed, came), [
            Joined(waiting, duty)
        ]  # nearly always
    kept = _with(_NONE if back else duties, stamp, duty)
    return _given_on(Feed(waiting, kept, seen, lost, blind, needed, came), [])


def on_deflection(
    feed: Feed, stamp: int, deflection: float, *, back: bool = False
) -> tuple[Feed, list[Joined]]:
    """Take a deflection [m]; the accelerations it completes. back: as in `on_duty`."""
    seen = _with((not back and feed.deflections) or _NONE, stamp, deflection)
    return _given_on(feed._replace(deflections=seen, came=True), [])


def _given_on(feed: Feed, ready: list[Joined]) -> tuple[Feed, list[Joined]]:
    """Give on what waits when it is complete, after what is ready already."""
    motion, duties, seen, lost, blind, needed, came = feed
    if motion is None or motion.stamp not in duties:
        return feed, ready
    if seen is not None and motion.stamp not in seen and (needed or came):
        return feed, ready
    ready.append(_joined(feed, motion))
    left = None if seen is None else _after(seen, motion.stamp)
    after = _after(duties, motion.stamp)
    return Feed(None, after, left, lost, blind, needed, came), ready


def _joined(feed: Feed, motion: Motion) -> Joined:
    """Accelerations with what has come of the other parts."""
    seen = feed.deflections or _NONE
    stamp = motion.stamp
    return Joined(motion, feed.duties.get(stamp, math.nan), seen.get(stamp, math.nan))


def _with(parts: _Parts, stamp: int, value: float) -> dict[int, float]:
    """One more part; the newest are kept."""
    more = {**parts, stamp: value}
    return more if len(more) <= DEPTH else {k: more[k] for k in sorted(more)[-DEPTH:]}


def _after(parts: _Parts, stamp: int) -> dict[int, float]:
    """Parts that can still meet their accelerations."""
    return {k: v for k, v in parts.items() if k > stamp}
