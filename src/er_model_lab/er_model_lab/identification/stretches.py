"""Stretches of constant duty in records, and the duty levels they make."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from er_models.prediction import Motion
from numpy.typing import NDArray

SAME = 0.05
"""Stretches whose duties differ by less than this share of the largest duty are at one level."""
OFF = 0.005
"""Share of the largest duty below which the field counts as off, and a change as none."""
SHORTEST = 0.5
"""Time at a level, once the force has settled, below which the level is not used [s]."""


@dataclass(frozen=True)
class Level:
    """A duty that was held: rows (n,) is the mask of the samples at which the force has settled to it."""

    duty: float
    rows: NDArray[np.bool_]


def stretches(motion: Motion) -> list[tuple[int, int]]:
    """First row and end of every stretch in which the duty stays what it is at its first sample."""
    width = OFF * max(float(motion.u.max()), 1e-12)
    found = []
    for first, end in itertools.pairwise(int(s) for s in motion.starts):
        i = first
        while i < end:
            j = _end(motion.u[i:end], width) + i
            found.append((i, j))
            i = j
    return found


def _end(u: NDArray[np.float64], width: float) -> int:
    """Number of samples until the duty (n,) leaves its first value; looked for in windows that double."""
    looked, window = 0, 64
    while looked < u.size:
        away = np.flatnonzero(np.abs(u[looked : looked + window] - u[0]) > width)
        if away.size:
            return looked + int(away[0])
        looked, window = looked + window, 2 * window
    return int(u.size)


def levels(motion: Motion, use: NDArray[np.bool_], settle: float) -> list[Level]:
    """Duty levels in rising order, from the used samples of each stretch but its first `settle` seconds.

    A level of duty 0 is the field switched off.
    """
    skip = round(settle / motion.dt)
    kept = [(i + skip, j) for i, j in stretches(motion) if j - i > skip]
    largest = max(float(motion.u.max()), 1e-12)
    duty = {s: _rounded(float(motion.u[s[0]]), largest) for s in kept}
    groups: list[list[tuple[int, int]]] = []
    for s in sorted(kept, key=lambda s: duty[s]):
        first = duty[groups[-1][0]] if groups else -np.inf
        if duty[s] - first > SAME * largest or first == 0.0 < duty[s]:
            groups.append([])
        groups[-1].append(s)
    return [level for group in groups if (level := _level(motion, use, group, largest))]


def _rounded(duty: float, largest: float) -> float:
    """The duty, 0 where the field counts as off."""
    return duty if duty > OFF * largest else 0.0


def _level(
    motion: Motion, use: NDArray[np.bool_], group: list[tuple[int, int]], largest: float
) -> Level | None:
    """One level of stretches; None when too little of it is used."""
    rows = np.zeros(motion.n, bool)
    for i, j in group:
        rows[i:j] = True
    rows &= use
    if rows.sum() * motion.dt < SHORTEST:
        return None
    return Level(_rounded(float(motion.u[rows].mean()), largest), rows)
