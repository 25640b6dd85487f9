"""The white noise of a signal, read off the signal alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from er_models.model import Array

QUARTER_OF_NORMAL = 0.3186
"""Quantile 0.25 of |z| for a normal z of standard deviation 1 [1]."""
THIRD_DIFFERENCE = 20.0
"""Variance of the third difference of white noise of variance 1: 1 + 9 + 9 + 1."""


def white_noise(parts: Sequence[Array]) -> float:
    """Standard deviation of the white noise of a signal in its unit, from its third differences; parts: (n,) each.

    The signal itself is smooth and leaves little in them; where it is not, they are large, so that their smallest
    quarter tells the noise. Differences with a lost sample (NaN) are left out; 0 where none remain.
    """
    d = np.abs(np.concatenate([np.diff(y, 3) for y in parts]))
    d = d[np.isfinite(d)]
    if not d.size:
        return 0.0
    return float(np.quantile(d, 0.25) / QUARTER_OF_NORMAL / np.sqrt(THIRD_DIFFERENCE))
