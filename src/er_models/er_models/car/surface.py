"""Four roads from one surface: two tracks, and the rear wheels where the front wheels were.

The right track is a mix of the left one and of another draw of the same road. Their coherence is the same at all
wavelengths; that of a real, isotropic surface falls from 1 for waves longer than the track to 0 for shorter ones
(Dodds and Robson 1973).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from er_models.car.body import Car
from er_models.errors import InputError
from er_models.model import Array
from er_models.program import Program

OTHER = 7919
"""Added to the seed for the draw that only the right track has."""


def four_roads(program: Program, car: Car, speed: float, coherence: float, t: Array) -> Array:
    """Heights below the corners at the times t (n,), (4, n) [m].

    speed: of the car [m/s], above zero; coherence: amplitude that both tracks share, -1 (all roll) to 1 (no roll). A
    road that is not random is the same in both tracks at 1, opposite at -1, and weaker in the right one between.

    Raises:
        InputError: A speed or coherence that cannot be.
    """
    if not 0.0 < speed < np.inf:
        raise InputError("surface", "speed", "a speed above 0 m/s", f"{speed:g}")
    if not -1.0 <= coherence <= 1.0:
        raise InputError("surface", "coherence", "-1 to 1", f"{coherence:g}")
    late = (car.to_front + car.to_rear) / speed
    rest = np.sqrt(1.0 - coherence**2)
    other = replace(program, seed=program.seed + OTHER)
    rows = []
    for delay in (0.0, late):
        left = _since_start(program, t - delay)
        right = coherence * left
        if rest and _random(program.road):
            right = right + rest * _since_start(other, t - delay)
        rows += [left, right]
    return np.array(rows)


def _since_start(program: Program, t: Array) -> Array:
    """Heights (n,): before its start a road is what it is at its start."""
    return program.heights(np.maximum(t, 0.0))


def _random(road: Mapping[str, object]) -> bool:
    """Whether another seed is another road."""
    return road.get("kind") in ("iso8608", "multisine", "sequence")
