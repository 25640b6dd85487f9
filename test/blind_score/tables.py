"""Shares with Wilson intervals."""

from __future__ import annotations

import math


def wilson(hits: int, n: int, z: float = 1.96) -> tuple[float, float]:
    """95 % interval of a share by Wilson's score; (0, 1) where nothing was tried."""
    if n == 0:
        return 0.0, 1.0
    p, w = hits / n, z * z / n
    centre = (p + 0.5 * w) / (1.0 + w)
    half = z / (1.0 + w) * math.sqrt(p * (1.0 - p) / n + 0.25 * w / n)
    return max(centre - half, 0.0), min(centre + half, 1.0)
