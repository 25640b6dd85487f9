"""Square wave between two levels, high first."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from er_models.spec import Array, Kind, Number

_ROUNDING = 1e-9
"""Share of a period by which a sample time may lie before its step through rounding."""


def make(s: Mapping[str, Any], t: Array, _seed: int) -> Array:
    """Duty [1], (n,)."""
    phase = np.mod(t * s["frequency"] + _ROUNDING, 1.0)
    return np.asarray(np.where(phase < s["share"], s["high"], s["low"]))


KIND = Kind(
    "square",
    "square wave between two levels",
    (
        Number("low", "duty", 0.0, 0.0, 1.0, "lower level"),
        Number("high", "duty", 0.3, 0.0, 1.0, "higher level"),
        Number("frequency", "Hz", 5.0, 0.0, 1e3, "frequency"),
        Number("share", "1", 0.5, 0.0, 1.0, "share of the period at the higher level"),
    ),
    make,
)
