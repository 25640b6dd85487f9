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


def bent_ends(y: Array) -> Mask:
    """Samples (n,) from the innermost one on that the parabola through three samples further inside misses by far."""
    bent = np.zeros(y.size, bool)
    if y.size < SHORTEST:
        return bent
    least = LEAST * float(np.ptp(np.quantile(y, (0.01, 0.99))))
    for side, mask in ((y, bent), (y[::-1], bent[::-1])):
        off = np.abs(np.diff(side, 3))
        inside = off[LAST:-LAST]
        usual, worst = NORMAL * float(np.median(inside)), float(np.quantile(inside, 0.999))
        bad = np.flatnonzero(off[:LAST] > max(FAR * usual, FURTHER * worst, least))
        if bad.size:
            mask[: int(bad[-1]) + 1 + BESIDE] = True
    return bent
