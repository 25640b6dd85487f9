"""Flat road at a height."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from er_models.spec import Array, Kind, Number


def make(s: Mapping[str, Any], t: Array, _seed: int) -> Array:
    """Height [m], (n,)."""
    return np.full(t.shape, s["height"])


KIND = Kind("flat", "flat road", (Number("height", "m", 0.0, -1.0, 1.0, "height"),), make)
