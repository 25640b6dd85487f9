"""The scored samples of all records as one set, and how they fall into bins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from er_model_lab.view import Array, RecordView


@dataclass(frozen=True, eq=False)
class Samples:
    """Scored samples of all records, arrays (n,), SI; `after` is None when nothing was added."""

    deflection: Array
    velocity: Array
    duty: Array
    measured: Array
    before: Array
    after: Array | None

    @property
    def models(self) -> tuple[tuple[str, Array], ...]:
        """Predictions by name."""
        if self.after is None:
            return (("model", self.before),)
        return (("model before", self.before), ("model after", self.after))

    @property
    def steps_duty(self) -> bool:
        """Whether the duty takes more than one value."""
        return bool(np.ptp(self.duty) > 1e-3)


def samples(records: Sequence[RecordView]) -> Samples | None:
    """All scored samples whose predictions are finite; None when there are none."""
    keep = [_usable(r) for r in records]
    if not any(k.any() for k in keep):
        return None

    def take(name: str) -> Array:
        return np.concatenate([getattr(r, name)[k] for r, k in zip(records, keep, strict=True)])

    after = take("after") if all(r.after is not None for r in records) else None
    return Samples(
        take("deflection"), take("velocity"), take("duty"), take("measured"), take("before"), after
    )  # fmt: skip


def _usable(record: RecordView) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Mask (n,) of scored samples that can be drawn."""
    good = record.scored & np.isfinite(record.measured) & np.isfinite(record.before)
    return good if record.after is None else good & np.isfinite(record.after)


def rms_map(
    x: Array, y: Array, value: Array, bins: tuple[int, int], fewest: int = 5
) -> tuple[Array, Array, Array]:
    """Rms of value (n,) per tile: x edges, y edges, z (rows, columns), NaN where too few."""
    ranges = [tuple(np.quantile(q, [0.002, 0.998])) for q in (x, y)]
    edges = [
        np.linspace(a, b if b > a else a + 1e-9, k + 1)
        for (a, b), k in zip(ranges, bins, strict=True)
    ]
    count, _, _ = np.histogram2d(x, y, edges)
    total, _, _ = np.histogram2d(x, y, edges, weights=value**2)
    z = np.where(count >= fewest, np.sqrt(total / np.maximum(count, 1)), np.nan)
    return edges[0], edges[1], z.T


LEVELS = np.concatenate([[0.0, 0.005, 0.02], np.linspace(0.05, 0.95, 19), [0.98, 0.995, 1.0]])
"""Quantiles between the bins of a mean: fine at both ends, where end stops and saturation show."""


def binned_mean(x: Array, y: Array, fewest: int = 5) -> tuple[Array, Array]:
    """Mean of y (n,) over bins of x (n,): centres and means of the bins with enough samples."""
    edges = np.unique(np.quantile(x, LEVELS))
    place = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, max(edges.size - 2, 0))
    count = np.bincount(place)
    full = count >= min(fewest, count.max())
    centres = np.bincount(place, x)[full] / count[full]
    return centres, np.bincount(place, y)[full] / count[full]


def margin(*arrays: Array) -> tuple[float, float]:
    """Range of all arrays with a small margin."""
    low, high = min(float(np.min(a)) for a in arrays), max(float(np.max(a)) for a in arrays)
    pad = 0.04 * max(high - low, 1e-9)
    return low - pad, high + pad
