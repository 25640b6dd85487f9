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

    spec: `kind`, one of `KINDS`, its settings and `factor`. The height at a time does not depend
    on which other times are asked for. Raises `InputError` for an unknown kind or key and for a
    value out of bounds.
    """
    kind = choose(KINDS, spec, "road")
    values = settings((*kind.settings, FACTOR), spec, "road")
    return np.asarray(values["factor"] * kind.make(values, t, seed))
