"""Several signals one after another, again and again: shared by the roads and the duty programs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from er_models.errors import InputError
from er_models.spec import REQUIRED, Array, Kind, Number, Parts, Setting, choose, settings

SECONDS = Number("seconds", "s", REQUIRED, 0.01, 1e5, "length of the part")
_ROUNDING = 1e-9
"""Time [s] by which a sample may lie before the part it belongs to through rounding."""


def parts_of(kinds: Mapping[str, Kind], more: tuple[Setting, ...] = ()) -> Parts:
    """The setting `parts`: specs of these kinds, each with its `seconds` and `more` settings."""
    return Parts("parts", REQUIRED, kinds, (SECONDS, *more), "specs in order, each with seconds")


def run(
    parts: Sequence[Mapping[str, Any]], setting: Parts, key: str, t: Array, seed: int
) -> tuple[Array, Array, Array]:
    """Values, time since the part began and time until it ends [s], each (n,).

    Part i takes the seed plus i. Raises `InputError` when there is no part.
    """
    if not len(parts):
        raise InputError(key, setting.name, "one or more parts", "none")
    ends = np.cumsum([float(part["seconds"]) for part in parts])
    within = np.mod(np.asarray(t, float) + _ROUNDING, ends[-1])
    which = np.minimum(np.searchsorted(ends, within, side="right"), len(parts) - 1)
    since = np.maximum(within - np.concatenate([[0.0], ends])[which] - _ROUNDING, 0.0)
    values = np.zeros(within.shape)
    for i, part in enumerate(parts):
        rows = which == i
        if rows.any():
            kind = choose(setting.kinds, part, key)
            read = settings((*kind.settings, *setting.more), part, key)
            values[rows] = read.get("factor", 1.0) * kind.make(read, since[rows], seed + i)
    return values, since, np.maximum(ends[which] - within, 0.0)
