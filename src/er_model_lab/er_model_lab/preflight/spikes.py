"""Samples that stand alone: a spike of the wiring or of a converter, which no neighbour shares.

A few samples in a row are predicted by the cubic through two samples on either side. One is wild where it lies far
beyond what such predictions miss in that part of the record, while its neighbours lie where they are predicted. A step,
a corner or a pulse of several samples moves its neighbours, too, and is never called wild. Two wild samples within four
are taken for such only where single ones are so many that chance puts two together.
"""

from __future__ import annotations

import numpy as np
from er_models.model import Array
from numpy.typing import NDArray

Mask = NDArray[np.bool_]

FAR, FINE = 10.0, 2.0
"""Robust deviations from which a sample is far away, and up to which its neighbours are where they should be."""
SHARE = 0.1
"""Share of a spike by which its neighbours may be off beside that: more is the shoulder of a pulse."""
LEAST = 0.01
"""Share of the channel's range that a spike has at least."""
STEEP = 0.2
"""Share of the way between both sides of it that a spike has at least: on a steep flank less is the flank's own."""
MOST = 0.02
"""Share of wild samples beyond which they are the nature of the channel."""
BLOCK = 50
"""Samples over which the size of what predictions miss is taken."""
PAIRS = ((0, 1, 1, 0), (0, 1, 0, 1, 0), (0, 1, 0, 0, 1, 0))
"""Two wild samples (1) and those about them."""
NORMAL = 1.4826
"""Standard deviation of normal noise over the median of its size."""


def spikes(y: Array, share: float = LEAST) -> Mask:
    """Samples (n,) of a channel in any unit that stand alone; none where they would be more than `MOST`.

    share: of the channel's range that they have at least.
    """
    wild = np.zeros(y.size, bool)
    if y.size < 2 * BLOCK:
        return wild
    least = share * float(np.ptp(np.quantile(y, (0.01, 0.99))))
    single = _found(y, (0, 1, 0), least)
    single &= _aside(y, least)
    wild |= single
    chance = 1.0 + 5.0 * single.sum() ** 2 / y.size
    for pattern in PAIRS:
        pair = _found(y, pattern, least)
        if pair.any() and single.sum() >= 3 and pair.sum() <= 2.0 * chance:
            wild |= pair
    return wild if wild.mean() <= MOST else np.zeros(y.size, bool)


def missed(y: Array, width: int) -> Array:
    """What the cubic through two samples on either side misses of `width` samples between (width, windows)."""
    nodes = np.array([-2.0, -1.0, width, width + 1.0])
    between = np.arange(float(width))
    weights = np.ones((width, 4))
    for i, j in ((i, j) for i in range(4) for j in range(4) if i != j):
        weights[:, i] *= (between - nodes[j]) / (nodes[i] - nodes[j])
    windows = np.lib.stride_tricks.sliding_window_view(y, width + 4)
    sides = windows[:, [0, 1, width + 2, width + 3]]
    return np.asarray((windows[:, 2 : width + 2] - sides @ weights.T).T)


def usual(e: Array) -> Array:
    """Robust standard deviation of deviations (n,) in their part of the record, no less than in all of it (n,)."""
    size = np.abs(e)
    length, longer = divmod(e.size, max(e.size // BLOCK, 1))
    ends = longer * (length + 1)  # as `array_split` parts them: the first ones are longer by one
    parts = size[:ends].reshape(longer, length + 1), size[ends:].reshape(-1, length)
    here = np.concatenate([np.median(each, axis=1) for each in parts if each.size])
    about = np.pad(here, 1, mode="edge")
    here = np.maximum(np.maximum(about[:-2], about[2:]), np.maximum(here, np.median(size)))
    lengths = np.repeat([p.shape[1] for p in parts], [p.shape[0] for p in parts])
    return np.asarray(NORMAL * np.repeat(here, lengths))


def _found(y: Array, pattern: tuple[int, ...], least: float) -> Mask:
    """Samples (n,) that are far away where the pattern says 1, with those between in place."""
    width, out = len(pattern), np.zeros(y.size, bool)
    e = missed(y, width)
    far = [k for k in range(width) if pattern[k]]
    height = np.abs(e[far]).min(axis=0)
    sides = np.lib.stride_tricks.sliding_window_view(y, width + 4)[:, [0, 1, width + 2, width + 3]]
    begun = np.flatnonzero(height > np.maximum(least, STEEP * np.ptp(sides, axis=1)))
    if not begun.size:
        return out
    scale = np.array([usual(row)[begun] for row in e])
    limit = np.where(np.array(pattern)[:, None] > 0, -FAR * scale, FINE * scale)
    fits = np.all(np.abs(e[far][:, begun]) > -limit[far], axis=0)
    fine = [k for k in range(width) if not pattern[k]]
    room = np.maximum(limit[fine], SHARE * height[begun])
    fits &= np.all(np.abs(e[fine][:, begun]) <= room, axis=0)
    for k in far:
        out[begun[fits] + 2 + k] = True
    return out


def _aside(y: Array, least: float) -> Mask:
    """Samples (n,) off the straight line through those before and off that through those behind, to the same side."""
    out = np.zeros(y.size, bool)
    before = y[2:-2] - 2.0 * y[1:-3] + y[:-4]
    behind = y[2:-2] - 2.0 * y[3:-1] + y[4:]
    out[2:-2] = (before * behind > 0.0) & (
        np.minimum(np.abs(before), np.abs(behind)) > 0.5 * least
    )
    off = missed(y, 3)[1]
    out[3:-3] &= np.minimum(np.abs(before), np.abs(behind))[1:-1] >= 0.5 * np.abs(off)
    return out
