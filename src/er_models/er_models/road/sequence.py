"""Roads one after another, again and again, each faded in and out so that the height never jumps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from er_models.sequence import parts_of, run
from er_models.spec import Array, Kind, Number, Setting


def kind(kinds: Mapping[str, Kind], more: tuple[Setting, ...]) -> Kind:
    """The kind `sequence` over other kinds of road, each part with `more` settings."""
    parts = parts_of(kinds, more)

    def make(s: Mapping[str, Any], t: Array, seed: int) -> Array:
        """Height [m], (n,)."""
        values, since, left = run(s["parts"], parts, "road", t, seed)
        edge = np.clip(np.minimum(since, left) / max(s["fade"], 1e-9), 0.0, 1.0)
        return np.asarray(values * 0.5 * (1.0 - np.cos(np.pi * edge)))

    fade = Number("fade", "s", 0.2, 0.0, 100.0, "time in which each part comes and goes")
    return Kind("sequence", "roads one after another, again and again", (parts, fade), make)
