"""Step of a given height, with a smooth (cosine) rise."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from er_models.spec import REQUIRED, Array, Kind, Number


def make(s: Mapping[str, Any], t: Array, _seed: int) -> Array:
    """Height [m], (n,); without a rise the sample at the time of the step is already up."""
    if s["rise"] == 0.0:
        return np.where(t >= s["time"] - 1e-9, s["height"], 0.0)
    share = np.clip((t - s["time"]) / s["rise"], 0.0, 1.0)
    return np.asarray(0.5 * s["height"] * (1.0 - np.cos(np.pi * share)))


KIND = Kind(
    "step",
    "step up (or down)",
    (
        Number("height", "m", REQUIRED, -1.0, 1.0, "height after the step"),
        Number("time", "s", 1.0, 0.0, 1e5, "when the step begins"),
        Number("rise", "s", 0.01, 0.0, 100.0, "how long it takes; 0 for a sudden one"),
    ),
    make,
)
