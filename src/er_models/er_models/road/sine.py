"""Sine: A sin(2 pi f t + phase)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from er_models.spec import REQUIRED, Array, Kind, Number


def make(s: Mapping[str, Any], t: Array, _seed: int) -> Array:
    """Height [m], (n,)."""
    return np.asarray(s["amplitude"] * np.sin(2.0 * np.pi * s["frequency"] * t + s["phase"]))


KIND = Kind(
    "sine",
    "sine wave",
    (
        Number("amplitude", "m", REQUIRED, -1.0, 1.0, "half the height from valley to crest"),
        Number("frequency", "Hz", REQUIRED, 0.0, 100.0, "frequency"),
        Number("phase", "rad", 0.0, -10.0, 10.0, "phase at t = 0"),
    ),
    make,
)
