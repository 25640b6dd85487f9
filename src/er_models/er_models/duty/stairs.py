"""Stairs: given levels one after another, each held equally long, again and again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from er_models.errors import InputError
from er_models.spec import Array, Kind, Number, Series

_ROUNDING = 1e-9
"""Share of a hold by which a sample time may lie before its step through rounding."""


def make(s: Mapping[str, Any], t: Array, _seed: int) -> Array:
    """Duty [1], (n,)."""
    levels = np.asarray(s["levels"], float)
    if not levels.size:
        raise InputError("duty", "levels", "one or more levels", "none")
    step = np.floor(t / s["hold"] + _ROUNDING).astype(int)
    return np.asarray(levels[np.mod(step, levels.size)])


KIND = Kind(
    "stairs",
    "given levels one after another",
    (
        Series("levels", "duty", (0.0, 0.1, 0.2, 0.3), 0.0, 1.0, "levels in order"),
        Number("hold", "s", 1.0, 1e-3, 1e5, "how long each is held"),
    ),
    make,
)
