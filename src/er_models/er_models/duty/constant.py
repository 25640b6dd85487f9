"""Constant duty."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from er_models.spec import Array, Kind, Number


def make(s: Mapping[str, Any], t: Array, _seed: int) -> Array:
    """Duty [1], (n,)."""
    return np.full(np.shape(t), s["level"])


KIND = Kind("constant", "constant duty", (Number("level", "duty", 0.0, 0.0, 1.0, "level"),), make)
