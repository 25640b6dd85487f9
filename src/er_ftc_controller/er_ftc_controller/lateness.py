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
MEMORY = 0.5
"""Memory of the means [s]."""
LEAST = 1e-5
"""Mean square of the difference beside which the next best must be larger: a duty that moved by 0.003."""
FAR = 4.0
"""So many times smaller is the mean square of the lateness that is believed."""


class Lateness(NamedTuple):
    """Duties said last and their times [s], newest first; mean squares of the differences by lateness.

    late: what is believed, in samples; None until something is.
    """

    said: tuple[tuple[float, float], ...] = ()
    misses: tuple[float, ...] = (0.0,) * (MOST + 1)
    late: int | None = None


def say(state: Lateness, t: float, duty: float) -> Lateness:
    """Remember the duty that was said at time t [s]."""
    return state._replace(said=((t, duty), *state.said[: MOST + 1]))


def hear(state: Lateness, t: float, acted: float, dt: float) -> Lateness:
    """Learn from the duty that acted in the sample that ends at t [s]; NaN for none. dt [s]: since the last sample."""
    if not (math.isfinite(acted) and len(state.said) > MOST):
        return state
    kept = math.exp(-dt / MEMORY)
    misses = tuple(
        kept * miss + (1.0 - kept) * (acted - duty) ** 2
        for miss, duty in zip(state.misses, _then(state, t), strict=True)
    )
    best = min(range(MOST + 1), key=misses.__getitem__)
    second = min(miss for d, miss in enumerate(misses) if d != best)
    sure = second > LEAST and second > FAR * misses[best]
    return state._replace(misses=misses, late=best if sure else state.late)


def _then(state: Lateness, t: float) -> list[float]:
    """The duty that stood at each lateness before the sample that ends at t [s]."""
    found, k = [], 0
    for d in range(MOST + 1):
        latest = t - (d + 0.5) * SAMPLE_TIME
        while k + 1 < len(state.said) and state.said[k][0] > latest:
            k += 1
        found.append(state.said[k][1])
    return found
