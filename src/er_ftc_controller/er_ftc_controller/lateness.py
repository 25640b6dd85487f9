r"""How late a duty acts, learnt from the duties that acted: the actuator's clock need not be known.

.. math::  d = \arg\min_d \; \overline{(u_{acted}(t) - u_{said}(t - T - d T))^2}

A duty that acts at once acts from its own sample to the next one, T later: that is d = 0. The means forget. A lateness
is believed where it fits far better than any other, so that a duty that stands still, or an actuator that does
something else, teaches nothing.

Source: matching by the mean square of the difference, as time delays are estimated everywhere (Knapp and Carter 1976).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from er_models.constants import SAMPLE_TIME

MOST = 5
"""Largest lateness that is looked for [samples]."""
EVERY = 4
"""Of so many samples one is learnt from: the loop pays for it, and lateness does not change by the sample."""
MEMORY = 0.5
"""Memory of the means [s]."""
SHARE = 1.0 - math.exp(-EVERY * SAMPLE_TIME / MEMORY)
"""Share of a new difference in the means."""
LEAST = 1e-5
"""Mean square of the difference beside which the next best must be larger: a duty that moved by 0.003."""
FAR = 4.0
"""So many times smaller is the mean square of the lateness that is believed."""


class Lateness(NamedTuple):
    """Duties said last and their times [s], newest first; mean squares of the differences by lateness.

    late: what is believed, in samples; None until something is. turn: samples until the next one that is learnt from.
    """

    said: tuple[tuple[float, float], ...] = ()
    misses: tuple[float, ...] = (0.0,) * (MOST + 1)
    late: int | None = None
    turn: int = 0


def say(state: Lateness, t: float, duty: float) -> Lateness:
    """Remember the duty that was said at time t [s]."""
    said, misses, late, turn = state
    return Lateness(((t, duty), *said[: MOST + 1]), misses, late, turn - 1 if turn else EVERY - 1)


def hear(state: Lateness, t: float, acted: float) -> Lateness:
    """Learn from the duty that acted in the sample that ends at t [s]; NaN for none."""
    said, misses, late, turn = state
    if turn or not math.isfinite(acted) or len(said) <= MOST:
        return state
    k, last, means = 0, len(said) - 1, []
    latest = t - 0.5 * SAMPLE_TIME
    for miss in misses:  # in the order of lateness: what stood then is further and further back
        while said[k][0] > latest and k < last:
            k += 1
        off = acted - said[k][1]
        means.append(miss + SHARE * (off * off - miss))
        latest -= SAMPLE_TIME
    best, second, *_ = sorted(means)
    sure = second > LEAST and second > FAR * best
    return Lateness(said, tuple(means), means.index(best) if sure else late, turn)
