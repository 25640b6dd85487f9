"""Random steps: levels drawn evenly from a range, each held for a random time; some at zero.

It is the excitation that separates most effects: steps show delays and lags, zeros the passive
force.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from er_models.errors import InputError
from er_models.spec import Array, Kind, Number


def make(s: Mapping[str, Any], t: Array, seed: int) -> Array:
    """Duty [1], (n,)."""
    for low, high in (("low", "high"), ("hold_min", "hold_max")):
        if s[low] > s[high]:
            raise InputError("duty", low, f"at most {high}, {s[high]:g}", f"{s[low]:g}")
    last = float(np.max(t)) if np.size(t) else 0.0
    rng = np.random.default_rng(seed)
    edges: list[float] = []
    levels: list[float] = []
    end = 0.0
    while not edges or end <= last:
        hold, level, zero = rng.random(3)
        edges.append(end)
        levels.append(0.0 if zero < s["zero_share"] else s["low"] + level * (s["high"] - s["low"]))
        end += s["hold_min"] + hold * (s["hold_max"] - s["hold_min"])
    return np.array(levels)[np.maximum(np.searchsorted(edges, t, side="right") - 1, 0)]


KIND = Kind(
    "steps",
    "random levels, each held for a random time",
    (
        Number("low", "duty", 0.0, 0.0, 1.0, "lowest level"),
        Number("high", "duty", 0.3, 0.0, 1.0, "highest level; the rig of the thesis allows 0.3"),
        Number("hold_min", "s", 0.3, 1e-3, 1e4, "shortest hold"),
        Number("hold_max", "s", 2.0, 1e-3, 1e4, "longest hold"),
        Number("zero_share", "1", 0.2, 0.0, 1.0, "share of the holds without field"),
    ),
    make,
)
