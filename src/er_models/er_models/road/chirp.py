"""Linear chirp: a sine whose frequency goes from f0 to f1 within `sweep`, then stays at f1.

The defaults are the first scenario of the thesis (3.6.1): 0 to 10 Hz with 4 mm.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from er_models.spec import Array, Kind, Number


def make(s: Mapping[str, Any], t: Array, _seed: int) -> Array:
    """Height [m], (n,); the phase is the integral of the frequency, so it never jumps."""
    inside = np.clip(t, 0.0, s["sweep"])
    cycles = s["f0"] * inside + 0.5 * (s["f1"] - s["f0"]) / s["sweep"] * inside**2
    cycles = cycles + s["f1"] * (np.maximum(t, s["sweep"]) - s["sweep"])
    return np.asarray(s["amplitude"] * np.sin(2.0 * np.pi * cycles))


KIND = Kind(
    "chirp",
    "sine with growing frequency",
    (
        Number("amplitude", "m", 0.004, -1.0, 1.0, "half the height from valley to crest"),
        Number("f0", "Hz", 0.0, 0.0, 100.0, "frequency at t = 0"),
        Number("f1", "Hz", 10.0, 0.0, 100.0, "frequency at t = sweep"),
        Number("sweep", "s", 20.0, 0.01, 1e5, "time of the sweep"),
    ),
    make,
)
