"""Ends of a channel that a filter has bent: its first and last samples, judged by what is inside."""

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


def bent_ends(y: Array, apart: Array | None = None) -> Mask:
    """Samples (n,) from the innermost one on that the parabola through three samples further inside misses by far.

    apart (n - 1,): by how much y and another channel part from each sample to the next. Where they part at an end as
    nowhere inside, a miss there counts though a harsh motion missed as much elsewhere.
    """
    bent = np.zeros(y.size, bool)
    if y.size < SHORTEST:
        return bent
    least = LEAST * float(np.ptp(np.quantile(y, (0.01, 0.99))))
    gap = np.zeros(y.size - 1) if apart is None else np.abs(apart)
    most = max(_limits(gap))
    for side, beside, mask in ((y, gap, bent), (y[::-1], gap[::-1], bent[::-1])):
        off = np.abs(np.diff(side, 3))
        usual, worst = _limits(off)
        alone = off > max(usual, worst, least)
        told = (off > usual) & (beside[: off.size] > most)
        _mark(mask, alone | told)
    return bent


def far_ends(left: Array) -> Mask:
    """Samples (n,) from the innermost one on that a model leaves far more of (n,) than of any inside."""
    bent = np.zeros(left.size, bool)
    if left.size < SHORTEST:
        return bent
    size = np.abs(left)
    most = max(_limits(size))
    for side, mask in ((size, bent), (size[::-1], bent[::-1])):
        _mark(mask, side > most)
    return bent


def _mark(mask: Mask, far: Mask) -> None:
    """Mark an end from the innermost of its samples on that are far away, and those beside it."""
    bad = np.flatnonzero(far[:LAST])
    if bad.size:
        mask[: int(bad[-1]) + 1 + BESIDE] = True


def _limits(off: Array) -> tuple[float, float]:
    """What is far from the usual, and further than nearly all, of samples that are no ends."""
    inside = off[LAST:-LAST]
    usual, worst = float(np.median(inside)), float(np.quantile(inside, 0.999))
    return FAR * NORMAL * usual, FURTHER * worst
