"""A sequence of bumps with edges of a cosine, driven over at constant speed.

An edge rises by h/2 (1 - cos pi s / (e L)) over its share e of the length L. Half the length makes the round bump
h/2 (1 - cos 2 pi s / L), less a plateau between two edges; 0 is a plank.

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
    up = np.minimum(inside, length - inside)
    width = s["edge"] * length
    share = np.clip(up / width, 0.0, 1.0) if width > 0.0 else np.ones(way.shape)
    return np.where(driven, 0.5 * s["height"] * (1.0 - np.cos(np.pi * share)), 0.0)


KIND = Kind(
    "bumps",
    "round or sharp bumps at constant speed",
    (
        Number("height", "m", 0.01, -1.0, 1.0, "height of a bump"),
        Number("length", "m", 5.0, 0.01, 1e3, "length of a bump"),
        Number(
            "spacing", "m", 5.0, 0.01, 1e4, "from the start of one bump to the start of the next"
        ),
        Number("speed", "m/s", 120.0 / 3.6, 0.0, 150.0, "speed of the car"),
        Number(
            "edge",
            "1",
            0.5,
            0.0,
            0.5,
            "share of the length in which a bump rises, and falls; 0.5 for a round one",
        ),
        Number("start", "m", 0.0, 0.0, 1e5, "way to the first bump"),
        Number("count", "1", 0.0, 0.0, 1e6, "number of bumps; 0 for no end"),
    ),
    make,
)
