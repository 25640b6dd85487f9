"""How a record was sampled, before anything was repaired."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

UNITS, WHOLE, HALF = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6), 0.02, 0.6
"""Units that times are rounded to [s]; how near to whole ones, and to the line, times must be, in such units."""
EVEN = 1e-3
"""Largest difference of steps that count as equal, as a share of a step."""
HOLE = 1.5
"""Steps longer than this many median steps have lost samples."""
MOST = 200
"""Holes that are remembered."""


@dataclass(frozen=True, slots=True)
class Timing:
    """Times of the rows as stored.

    rows: how many; dt: median step [s]; jitter: rms deviation of the steps without holes from it [s]; where the times
    are equal steps that were rounded, dt is that step, unit what they were rounded to [s] and jitter 0;
    lost: samples missing in holes; longest: longest step [s]; repeated: rows at the time of the row before;
    holes: the times before and after each of the longest holes, at most `MOST`, in their order [s].
    """

    rows: int
    dt: float
    jitter: float
    lost: int
    longest: float
    repeated: int
    holes: tuple[tuple[float, float], ...] = ()
    unit: float = 0.0


def timing_of(t: Array) -> Timing:
    """Timing of sorted times (N,) [s], N at least 2 and not all of them equal, else zeros."""
    steps = np.diff(t)
    forward = steps[steps > 0.0]
    if not forward.size:
        return Timing(int(t.size), 0.0, 0.0, 0, 0.0, int(steps.size))
    line = rounded(t) if np.ptp(forward) > EVEN * np.median(forward) else None
    dt = float(np.median(forward)) if line is None else line[1]
    holes = forward > HOLE * dt
    jitter = float(np.sqrt(np.mean((forward[~holes] - dt) ** 2))) if line is None else 0.0
    lost = int(np.sum(np.round(forward[holes] / dt) - 1.0))
    rows = np.flatnonzero(steps > HOLE * dt)
    longest = np.sort(rows[np.argsort(-steps[rows], kind="stable")[:MOST]])
    return Timing(
        int(t.size), dt, jitter, lost, float(forward.max()), int(steps.size - forward.size),
        tuple((float(t[k]), float(t[k + 1])) for k in longest), 0.0 if line is None else line[2],
    )  # fmt: skip


def rounded(t: Array) -> tuple[float, float, float] | None:
    """First time and step of equal steps whose times (n,) are these, rounded, and to what [s]; None: they are not."""
    unit = next((u for u in UNITS if np.max(np.abs(t / u - np.round(t / u))) < WHOLE), None)
    if unit is None:
        return None
    k = np.arange(t.size)
    step, late = (float(c) for c in np.polyfit(k, t - t[0], 1))
    missed = float(np.max(np.abs(late + step * k - (t - t[0]))))
    return (float(t[0]) + late, step, unit) if missed < HALF * unit else None
