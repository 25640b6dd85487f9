"""Road profiles: one small file each; `road_profile` makes any of them from a mapping of settings."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from er_models.road import (
    bumps,
    chirp,
    flat,
    iso8608,
    multisine,
    recorded,
    sequence,
    sine,
    step,
    triangle,
)
from er_models.spec import Array, Kind, Number, choose, settings

FACTOR = Number(
    "factor", "1", 1.0, -1e3, 1e3, "multiplies the height, e.g. 0.2 for a car of scale 1/5"
)
"""A setting that every road takes."""
STRAIGHT = Number(
    "straight", "s", 0.0, 0.0, 1.0, "straight between points so far apart; 0 for the road itself"
)
"""Another one: a special case, for what is made for such roads."""
COMMON = (FACTOR, STRAIGHT)
_ROUNDING = 1e-9
"""Share of the way between two points that a time may lie before one through rounding."""

_SINGLE = {
    module.KIND.name: module.KIND
    for module in (flat, sine, triangle, multisine, chirp, step, bumps, iso8608)
}
_SEVERAL = sequence.kind(_SINGLE, (FACTOR,))

KINDS: dict[str, Kind] = {
    **_SINGLE,
    recorded.KIND.name: recorded.KIND,
    _SEVERAL.name: _SEVERAL,
}


def road_profile(spec: Mapping[str, object], t: Array, seed: int = 0) -> Array:
    """Height of the road [m] at the times t [s], shape (n,).

    spec: `kind`, one of `KINDS`, its settings, `factor` and `straight`. The height at a time does not depend
    on which other times are asked for. Raises `InputError` for an unknown kind or key and for a
    value out of bounds.
    """
    kind = choose(KINDS, spec, "road")
    values = settings((*kind.settings, *COMMON), spec, "road")
    apart = values["straight"]
    if not apart:
        return np.asarray(values["factor"] * kind.make(values, t, seed))
    place = np.asarray(t, float) / apart
    first = np.floor(place + _ROUNDING)
    nodes, where = np.unique(np.concatenate([first, first + 1.0]), return_inverse=True)
    begin, end = kind.make(values, apart * nodes, seed)[where].reshape(2, -1)
    return np.asarray(values["factor"] * (begin + (end - begin) * np.maximum(place - first, 0.0)))
