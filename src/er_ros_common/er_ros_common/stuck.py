"""Sensors that say the same number again and again, bit for bit, while they should not. Pure.

A field is stuck when it has not changed for `AFTER` while another field of its message did, most of the time; or when
nothing of the message changed although a value says that something moves. A sensor whose resolution is coarser than
the noise of what it measures repeats itself too, and is told as stuck where the other field moves.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

AFTER = 100_000_000
"""Time without any change that is not chance: 20 samples at 200 Hz [ns]."""
SHARE = 0.5
"""Part of that time's samples in which another field changed."""


ACCELERATION = (0.2, 0.2)
"""Four times the noise that the observers allow an accelerometer [m/s2]."""
DEFLECTION = (math.inf, 0.01)
"""Any deflection may stay; a velocity above this may not [m, m/s]."""


class Watched(NamedTuple):
    """Last values, and the stamp of the last change of any [ns].

    Where one has stayed, for each: stamp of its last change [ns], samples since, those in which another one changed.
    """

    values: tuple[float, ...] = ()
    changed: int = 0
    since: tuple[int, ...] = ()
    same: tuple[int, ...] = ()
    others: tuple[int, ...] = ()


def check(
    state: Watched, values: tuple[float, ...], resting: Sequence[float], stamp: int
) -> tuple[Watched, bool]:
    """Whether any field is stuck at this stamp [ns].

    Args:
        state: after the sample before; `Watched()` at the start.
        values: of the fields of one message (n,).
        resting: magnitude of each up to which standing still explains it (n,); inf where any constant does.
        stamp: of the message [ns].
    """
    before, last = state.values, state.changed
    if len(before) != len(values) or stamp <= last:
        return Watched(values, stamp), False
    for a, b in zip(values, before, strict=True):
        if a == b or a != a:
            return _stayed(state, values, resting, stamp)
    return Watched(values, stamp), False


def _stayed(
    state: Watched, values: tuple[float, ...], resting: Sequence[float], stamp: int
) -> tuple[Watched, bool]:
    """The same where a field may not have changed; NaN after NaN is no change."""
    n, zeros = len(values), (0,) * len(values)
    changed = [
        a != b and not (math.isnan(a) and math.isnan(b))
        for a, b in zip(values, state.values, strict=True)
    ]
    moved = any(changed)
    since = list(state.since or (state.changed,) * n)
    same, others = list(state.same or zeros), list(state.others or zeros)
    for i, each in enumerate(changed):
        since[i] = stamp if each else since[i]
        same[i] = 0 if each else same[i] + 1
        others[i] = 0 if each else others[i] + moved
    long = [stamp - since[i] >= AFTER for i in range(n)]
    one = any(long[i] and others[i] >= SHARE * same[i] for i in range(n))
    everything = all(long) and any(abs(v) > r for v, r in zip(values, resting, strict=True))
    return (
        Watched(values, max(since), tuple(since), tuple(same), tuple(others)),
        one or everything,
    )
