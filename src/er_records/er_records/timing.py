"""How a record was sampled, before anything was repaired."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

HOLE = 1.5
"""Steps longer than this many median steps have lost samples."""
MOST = 200
"""Holes that are remembered."""


@dataclass(frozen=True, slots=True)
class Timing:
    """Times of the rows as stored.

    rows: how many; dt: median step [s]; jitter: rms deviation of the steps without holes from it [s];
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


def timing_of(t: Array) -> Timing:
    """Timing of sorted times (N,) [s], N at least 2 and not all of them equal, else zeros."""
    steps = np.diff(t)
    forward = steps[steps > 0.0]
    if not forward.size:
        return Timing(int(t.size), 0.0, 0.0, 0, 0.0, int(steps.size))
    dt = float(np.median(forward))
    holes = forward > HOLE * dt
    jitter = float(np.sqrt(np.mean((forward[~holes] - dt) ** 2)))
    lost = int(np.sum(np.round(forward[holes] / dt) - 1.0))
    rows = np.flatnonzero(steps > HOLE * dt)
    longest = np.sort(rows[np.argsort(-steps[rows], kind="stable")[:MOST]])
    return Timing(
        int(t.size), dt, jitter, lost, float(forward.max()), int(steps.size - forward.size),
        tuple((float(t[k]), float(t[k + 1])) for k in longest),
    )  # fmt: skip
