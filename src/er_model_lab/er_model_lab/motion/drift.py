"""The drift of a deflection that was integrated from a velocity: a line that bends once a minute."""

from __future__ import annotations

import numpy as np
from er_models.model import Array

BENDS = 60.0
"""Time from bend to bend [s]: what an offset of a velocity makes of a deflection is as good as straight between."""


def without_drift(x: Array, v: Array, dt: float) -> tuple[Array, Array]:
    """Deflection [m] and velocity [m/s] (n,) without the drift of the deflection."""
    line, slope = drift(x, dt)
    return x - line, v - slope


def drift(x: Array, dt: float) -> tuple[Array, Array]:
    """Drift (n,) [m] of a deflection (n,) [m] and its slope (n,) [m/s]: the nearest continuous line with such bends."""
    n = x.size
    parts = max(round(n * dt / BENDS), 1)
    place = np.arange(n) * (parts / max(n - 1, 1))
    i = np.minimum(place.astype(np.intp), parts - 1)
    w = place - i
    hats = (1.0 - w, w)
    a, b, k = np.zeros((parts + 1, parts + 1)), np.zeros(parts + 1), np.arange(parts)
    for r, row in enumerate(hats):
        b[k + r] += np.bincount(i, row * x, parts)
        for c, column in enumerate(hats):
            a[k + r, k + c] += np.bincount(i, row * column, parts)
    at = np.linalg.lstsq(a, b, rcond=None)[0]
    line = at[i] * (1.0 - w) + at[i + 1] * w
    slope = np.diff(at)[i] * parts / (max(n - 1, 1) * dt)
    return line, slope
