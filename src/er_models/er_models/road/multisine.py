"""Several sines at once, sum of A_i sin(2 pi f_i t + phase_i), with phases from the seed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from er_models.errors import InputError
from er_models.spec import REQUIRED, Array, Kind, Series


def make(s: Mapping[str, Any], t: Array, seed: int) -> Array:
    """Height [m], (n,)."""
    amplitudes, frequencies = np.asarray(s["amplitudes"]), np.asarray(s["frequencies"])
    if amplitudes.size != frequencies.size or not amplitudes.size:
        raise InputError(
            "road", "amplitudes", "as many amplitudes as frequencies, one or more",
            f"{amplitudes.size} and {frequencies.size}",
        )  # fmt: skip
    phase = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, frequencies.size)
    waves = np.sin(2.0 * np.pi * np.multiply.outer(t, frequencies) + phase)
    return np.asarray(waves @ amplitudes)


KIND = Kind(
    "multisine",
    "several sines at once, their phases random",
    (
        Series("amplitudes", "m", REQUIRED, -1.0, 1.0, "amplitude of each sine"),
        Series("frequencies", "Hz", REQUIRED, 0.0, 100.0, "frequency of each sine"),
    ),
    make,
)
