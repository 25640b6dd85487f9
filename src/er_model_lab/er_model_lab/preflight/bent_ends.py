"""Ends of a channel that a filter has bent: its first and last samples, judged by extrapolation from inside."""

from __future__ import annotations

import numpy as np
from er_models.model import Array

from er_model_lab.preflight.spikes import LEAST, NORMAL, Mask

LAST = 8
"""Samples of an end that are judged."""
SHORTEST = 100
"""Samples of a channel below which nothing is known of its inside."""
FAR, FURTHER = 10.0, 2.0
"""Robust deviations from which an extrapolation fails, and how many times what it misses at its worst inside, one in a
thousand aside."""
BESIDE = 2
"""Samples beside a bent one that are not believed either."""


def bent_ends(y: Array, beside: Array | None = None) -> Mask:
    """Samples (n,) from the innermost one on that the parabola through three samples further inside misses by far.

    beside (n - 1,): what another channel says that y does from each sample to the next, less what it does. Where the
    two part at an end as nowhere inside, a miss there counts though a harsh motion missed as much elsewhere.
    """
    bent = np.zeros(y.size, bool)
    if y.size < SHORTEST:
        return bent
    least = LEAST * float(np.ptp(np.quantile(y, (0.01, 0.99))))
    sides = [(y, beside, bent)]
    sides += [(y[::-1], None if beside is None else beside[::-1], bent[::-1])]
    for side, apart, mask in sides:
        off = np.abs(np.diff(side, 3))
        usual, worst = _inside(off)
        far = off[:LAST] > max(usual, worst, least)
        if apart is not None:
            gap = np.abs(apart)
            far |= (off[:LAST] > usual) & (gap[:LAST] > max(_inside(gap)))
        bad = np.flatnonzero(far)
        if bad.size:
            mask[: int(bad[-1]) + 1 + BESIDE] = True
    return bent


def _inside(off: Array) -> tuple[float, float]:
    """What is far beside the usual, and further than nearly all, of samples that are no ends."""
    inside = off[LAST:-LAST]
    usual, worst = float(np.median(inside)), float(np.quantile(inside, 0.999))
    return FAR * NORMAL * usual, FURTHER * worst
