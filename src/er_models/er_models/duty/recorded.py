"""Recorded duty: a column of a CSV or Parquet file, or given values; each held until the next."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from er_models.errors import InputError
from er_models.road.recorded import place, samples, settings_of
from er_models.spec import Array, Kind

_ROUNDING = 1e-9
"""Time [s] by which a sample may lie before its own row through rounding."""


def make(s: Mapping[str, Any], t: Array, _seed: int) -> Array:
    """Duty [1], (n,); a record that repeats holds its last row as long as the one before."""
    times, levels = samples(s, "duty")
    if levels.min() < 0.0 or levels.max() > 1.0:
        found = f"{levels.min():g} to {levels.max():g}"
        raise InputError(s["file"] or "duty", s["column"], "a duty of 0 to 1", found)
    end = float(times[-1] + (times[-1] - times[-2] if times.size > 1 else 0.0))
    row = np.searchsorted(times, place(s, t, end) + _ROUNDING, side="right") - 1
    return levels[np.clip(row, 0, levels.size - 1)]


KIND = Kind("recorded", "recorded duty", settings_of("duty", "duty", 0.0, 1.0), make)
