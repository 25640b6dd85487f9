"""Joins accelerations with the duty applied from then on; a lost duty holds nothing up. Pure.

The duty of a tick is published after its accelerations. Where it has not come before the
accelerations of the next tick, these are given on with NaN as duty, which the observers take for
"as before".
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

DEPTH = 10
"""Duties kept that are ahead of their accelerations."""


class Motion(NamedTuple):
    """Accelerations [m/s2] of a tick: stamp [ns], sequence number, sprung, unsprung."""

    stamp: int
    seq: int
    sprung: float
    unsprung: float


class Joined(NamedTuple):
    """Accelerations and the duty from then on; NaN where it was lost."""

    motion: Motion
    duty: float


class Feed(NamedTuple):
    """Accelerations that wait for their duty, duties that wait for accelerations, duties lost."""

    waiting: Motion | None = None
    duties: Mapping[int, float] = MappingProxyType({})
    lost: int = 0


def on_motion(feed: Feed, motion: Motion) -> tuple[Feed, list[Joined]]:
    """Take accelerations; what can be given on now, oldest first."""
    ready = [Joined(feed.waiting, math.nan)] if feed.waiting else []
    feed = Feed(None, feed.duties, feed.lost + len(ready))
    if motion.stamp not in feed.duties:
        return feed._replace(waiting=motion), ready
    ready.append(Joined(motion, feed.duties[motion.stamp]))
    return feed._replace(duties=_after(feed.duties, motion.stamp)), ready


def on_duty(feed: Feed, stamp: int, duty: float) -> tuple[Feed, list[Joined]]:
    """Take a duty; the accelerations it completes."""
    if feed.waiting and feed.waiting.stamp == stamp:
        ready = [Joined(feed.waiting, duty)]
        return Feed(None, _after(feed.duties, stamp), feed.lost), ready
    duties = {**feed.duties, stamp: duty}
    newest = sorted(duties)[-DEPTH:]
    return feed._replace(duties={k: duties[k] for k in newest}), []


def _after(duties: Mapping[int, float], stamp: int) -> dict[int, float]:
    """Duties that can still meet their accelerations."""
    return {k: v for k, v in duties.items() if k > stamp}
