"""Sine about a mean, cut off at 0 and 1.

The defaults are the 0.1 Hz sine of the thesis (chapter 4, scenario 2) within its rig's range.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from er_models.spec import Array, Kind, Number


def make(s: Mapping[str, Any], t: Array, _seed: int) -> Array:
    """Duty [1], (n,)."""
    wave = s["mean"] + s["amplitude"] * np.sin(2.0 * np.pi * s["frequency"] * t + s["phase"])
    return np.asarray(np.clip(wave, 0.0, 1.0))


KIND = Kind(
    "sine",
    "slow sine about a mean",
    (
        Number("mean", "duty", 0.15, 0.0, 1.0, "mean"),
        Number("amplitude", "duty", 0.15, 0.0, 1.0, "half the range"),
        Number("frequency", "Hz", 0.1, 0.0, 100.0, "frequency"),
        Number("phase", "rad", 0.0, -10.0, 10.0, "phase at t = 0"),
    ),
    make,
)
