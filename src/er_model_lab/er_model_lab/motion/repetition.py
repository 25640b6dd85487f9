"""Motion that repeats itself: a record that is one closed curve, run through again and again.

On such a curve deflection, velocity, acceleration and the time within a cycle are functions of one another, so that
whatever depends on one of them may as well depend on another; and an error of the fused motion comes back in every
cycle instead of averaging out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rows = Sequence[tuple[int, int]]
"""From and to of each record, all of them laid end to end."""

CLOSED = 0.98
"""Share of the velocity's power that its course over the phase must explain."""
PHASES = 64
"""Parts of a cycle."""
FEWEST = 4.0
"""Cycles a record must hold."""
RUN_IN = 0.05
"""Share of the cycles that may be others: a test machine runs up, and the free vibration of the start dies away."""
MOST = 20_000
"""Samples looked at."""
MULTIPLES, STEPS = (1, 2, 3), 41
"""Cycles of the strongest line that may make a period, and frequencies tried about each."""
FEW_CURVES = 2
"""Different closed curves up to which effects of the motion cannot be told apart."""
REMEDY = "record several frequencies or a sweep"
"""What would tell effects apart."""
ALIKE = 0.1
"""Difference of frequency or size, as a share, up to which two curves are one."""


@dataclass(frozen=True)
class Cycle:
    """A motion that repeats itself: its frequency [Hz] and the share of the velocity's power in the cycle."""

    frequency: float
    share: float


def cycle(velocity: Array, dt: float) -> Cycle | None:
    """The cycle that a record (n,) repeats; None where it repeats none, or too seldom to say so."""
    v = velocity[:MOST] - velocity[:MOST].mean()
    n = v.size
    if n < 2 * PHASES or not np.any(v):
        return None
    spectrum = np.abs(np.fft.rfft(v * np.hanning(n)))
    peak, width = float(np.argmax(spectrum[1:]) + 1) / (n * dt), 1.0 / (n * dt)
    found = [
        Cycle(f, _share(v, f * dt))
        for m in MULTIPLES
        for f in peak / m + width * np.linspace(-1.0, 1.0, STEPS)
        if f * n * dt >= FEWEST
    ]
    best = max(found, key=lambda c: c.share, default=None)
    return best if best is not None and best.share >= CLOSED else None


def _share(v: Array, step: float) -> float:
    """Share of the variance of a signal that its mean over the phase explains, less what chance explains.

    The cycles that keep least to the mean are left out, `RUN_IN` of them. step: part of a cycle from sample to sample.
    """
    place = ((np.arange(v.size) * step) % 1.0 * PHASES).astype(np.intp)
    number = (np.arange(v.size) * step).astype(np.intp)
    rest = np.bincount(number, _rest(v, place))
    others = np.argsort(rest)[rest.size - int(RUN_IN * rest.size) :]
    kept = ~np.isin(number, others)
    left = float(np.sum(_rest(v[kept], place[kept]))) / max(int(kept.sum()) - PHASES, 1)
    return 1.0 - left / max(float(np.mean(v[kept] ** 2)), 1e-300)


def _rest(v: Array, place: NDArray[np.intp]) -> Array:
    """Squares of what the mean over the phase does not explain; place: each sample's part of its cycle."""
    count = np.maximum(np.bincount(place, minlength=PHASES), 1)
    mean = np.bincount(place, v, PHASES) / count
    rest: Array = (v - mean[place]) ** 2
    return rest


def cycles(velocity: Array, dt: float, rows: Rows) -> tuple[Cycle, ...]:
    """The cycle of each record, which lies in these rows; nothing when one of them repeats none."""
    found = [cycle(velocity[i:j], dt) for i, j in rows]
    kept = tuple(c for c in found if c is not None)
    return kept if len(kept) == len(found) else ()


def curves(found: tuple[Cycle, ...], velocity: Array, rows: Rows) -> int:
    """How many different closed curves the records run through."""
    sizes = [float(np.std(velocity[i:j])) for i, j in rows]
    different: list[tuple[float, float]] = []
    for c, size in zip(found, sizes, strict=False):
        known = any(
            abs(c.frequency - f) <= ALIKE * f and abs(size - s) <= ALIKE * s for f, s in different
        )
        if not known:
            different.append((c.frequency, size))
    return len(different)


def one_curve(frequency: float) -> str:
    """What such a motion cannot show."""
    return (
        f"the motion repeats one closed curve at {frequency:.3g} Hz: nothing that depends on deflection, velocity, "
        "acceleration or the time within a cycle can be told apart"
    )
