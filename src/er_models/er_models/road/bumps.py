"""A sequence of sinusoidal bumps, h/2 (1 - cos 2 pi s / L), driven over at constant speed.

Validation case 3 of the thesis (1.6) drives over 10 mm bumps at 120 km/h; it does not give their
length, the default of 5 m makes them 6.7 Hz. `count` 0 repeats them for ever.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from er_models.errors import InputError
from er_models.spec import Array, Kind, Number


def make(s: Mapping[str, Any], t: Array, _seed: int) -> Array:
    """Height [m], (n,)."""
    length, spacing = s["length"], s["spacing"]
    if spacing < length:
        raise InputError(
            "road", "spacing", f"at least the length of a bump, {length:g} m", f"{spacing:g}"
        )
    way = s["speed"] * np.asarray(t, float) - s["start"]
    number = np.floor(way / spacing)
    inside = way - number * spacing
    driven = (way >= 0.0) & (inside < length) & ((s["count"] == 0) | (number < s["count"]))
    return np.where(driven, 0.5 * s["height"] * (1.0 - np.cos(2.0 * np.pi * inside / length)), 0.0)


KIND = Kind(
    "bumps",
    "sinusoidal bumps at constant speed",
    (
        Number("height", "m", 0.01, -1.0, 1.0, "height of a bump"),
        Number("length", "m", 5.0, 0.01, 1e3, "length of a bump"),
        Number(
            "spacing", "m", 5.0, 0.01, 1e4, "from the start of one bump to the start of the next"
        ),
        Number("speed", "m/s", 120.0 / 3.6, 0.0, 150.0, "speed of the car"),
        Number("start", "m", 0.0, 0.0, 1e5, "way to the first bump"),
        Number("count", "1", 0.0, 0.0, 1e6, "number of bumps; 0 for no end"),
    ),
    make,
)
