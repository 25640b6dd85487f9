"""Which part of long data is drawn: thinning that keeps peaks, and where to look first."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from er_model_lab.view import Array, RecordView

MOST_POINTS = 4000
"""Points of one curve that are drawn at once."""


def min_max(y: Array, most: int = MOST_POINTS) -> NDArray[np.int64]:
    """Rows (m,) of y (n,) to draw: the lowest and highest of each of equal stretches, in order.

    Both ends and the start of every gap (NaN or infinite) stay too; all rows when n <= most.
    """
    n = y.size
    if n <= most:
        return np.arange(n)
    good = np.isfinite(y)
    gaps = np.flatnonzero(~good & np.concatenate([[True], good[:-1]]))
    width = -(-n // max((most - 2) // 2, 1))
    fill = -n % width
    low = np.concatenate([np.where(good, y, np.inf), np.full(fill, np.inf)]).reshape(-1, width)
    high = np.concatenate([np.where(good, y, -np.inf), np.full(fill, -np.inf)]).reshape(-1, width)
    first = np.arange(low.shape[0]) * width
    rows = np.concatenate(
        [first + low.argmin(axis=1), first + high.argmax(axis=1), gaps, [0, n - 1]]
    )
    return np.unique(rows[rows < n])


def every(n: int, most: int) -> NDArray[np.int64]:
    """At most `most` rows spread evenly over n."""
    return np.unique(np.linspace(0, n - 1, min(n, most)).astype(np.int64))


def stretches(t: Array, mask: NDArray[np.bool_]) -> tuple[tuple[float, float], ...]:
    """Intervals of t (n,) in which the mask (n,) holds."""
    padded = np.concatenate([[False], mask, [False]])
    flips = np.flatnonzero(padded[1:] != padded[:-1])
    return tuple(
        (float(t[i]), float(t[j - 1])) for i, j in zip(flips[::2], flips[1::2], strict=True)
    )


def timeline(records: Sequence[RecordView]) -> tuple[Array, ...]:
    """Time (n,) of each record [s], laid end to end with a gap; one record keeps its own."""
    if len(records) == 1:
        return (records[0].t,)
    gap = max(0.5, 0.01 * sum(float(np.ptp(r.t)) for r in records))
    out, start = [], 0.0
    for r in records:
        out.append(start + r.t - r.t[0])
        start = float(out[-1][-1]) + gap
    return tuple(out)


def end_to_end(parts: Sequence[Array]) -> Array:
    """One array with a NaN between the parts, so that no curve joins two records."""
    joined: list[Array] = [parts[0]]
    for before, after in pairwise(parts):
        joined += [np.full(min(before.size, 1), np.nan), after]
    return np.concatenate(joined)


def worst_stretch(record: RecordView, seconds: float) -> tuple[float, float, float]:
    """Start, end [s] and rms of the stretch in which the model as it was errs most."""
    error = np.where(record.scored, record.measured - record.before, 0.0)
    squared = np.where(np.isfinite(error), error, 0.0) ** 2
    dt = float(np.median(np.diff(record.t)))
    width = min(max(round(seconds / dt), 2), record.t.size)
    total = np.concatenate([[0.0], np.cumsum(squared)])
    means = (total[width:] - total[:-width]) / width
    i = int(np.argmax(means))
    return float(record.t[i]), float(record.t[i + width - 1]), float(np.sqrt(means[i]))
