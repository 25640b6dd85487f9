"""Sensor errors of the simulated rig: white noise and constant bias.

The noise is drawn in blocks from a counter-based generator, so that the error at a tick depends on
the seed and the tick alone: not on the mode, the speed or what was asked for before.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

BLOCK = 1024
"""Ticks drawn at once."""


class Errors(NamedTuple):
    """What is added to each sensor, or its standard deviation or bias: SI units of the sensor."""

    sprung_acceleration: float
    unsprung_acceleration: float
    deflection: float
    deflection_velocity: float
    force: float


PERFECT = Errors(0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Noise:
    """Standard deviations and biases of the sensors, and the seed of the draw; equal only to itself."""

    deviation: Errors = PERFECT
    bias: Errors = PERFECT
    seed: int = 0


def errors(noise: Noise, tick: int) -> Errors:
    """Errors of all sensors at a tick (0 or later)."""
    block, row = divmod(tick, BLOCK)
    return Errors(*_block(noise, block)[row].tolist())


@lru_cache(maxsize=4)
def _block(noise: Noise, block: int) -> Array:
    """Errors (BLOCK, 5) of one block of ticks."""
    draw = np.random.Generator(np.random.Philox(key=noise.seed, counter=[0, 0, 0, block]))
    values = draw.standard_normal((BLOCK, len(Errors._fields))) * np.array(noise.deviation)
    return np.asarray(values + np.array(noise.bias), np.float64)
