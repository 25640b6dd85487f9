"""Triangle with rounded corners: ramps of constant velocity, A asin(k sin 2 pi f t) / asin(k).

With k towards 1 the corners are sharp and the velocity is 4 A f nearly everywhere; k below 1 keeps
the acceleration finite. It shows the force at one velocity, whatever the deflection.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from er_models.spec import REQUIRED, Array, Kind, Number


def make(s: Mapping[str, Any], t: Array, _seed: int) -> Array:
    """Height [m], (n,)."""
    k = s["sharpness"]
    return np.asarray(
        s["amplitude"] * np.arcsin(k * np.sin(2.0 * np.pi * s["frequency"] * t)) / np.arcsin(k)
    )


KIND = Kind(
    "triangle",
    "ramps of constant velocity up and down",
    (
        Number("amplitude", "m", REQUIRED, -1.0, 1.0, "half the height from valley to crest"),
        Number("frequency", "Hz", REQUIRED, 0.0, 100.0, "frequency"),
        Number("sharpness", "1", 0.98, 0.01, 0.9999, "towards 0 a sine, towards 1 a triangle"),
    ),
    make,
)
