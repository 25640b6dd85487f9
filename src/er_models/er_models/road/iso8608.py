"""Random road of ISO 8608: spectrum Gd(n) = Gd(n0) (n / n0)^-2 with n0 = 0.1 cycles/m.

ISO 8608:1995 (and 2016), Table C.1: the geometric mean of Gd(n0) is 16e-6 m3 for class A and four
times more for each class after it; a class reaches from half to twice its mean. The exponent is 2,
the spectrum one-sided and valid from 0.011 to 2.83 cycles/m, which are the limits here.

The road is a sum of sines with random phases (Shinozuka and Jan 1972). Their frequencies stand one
in each of `lines` cells, equally wide in log n and at a random place within the cell; a sine
carries the power of its cell. So the road never repeats, needs no knowledge of the length of the
record, and has the standard's power in every band however narrow the resonance of the car.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from er_models.errors import InputError
from er_models.spec import Array, Kind, Number, Text

CLASSES = "ABCDEFGH"
N_0 = 0.1
"""Reference spatial frequency [cycles/m]."""
LINES = 1024
_BLOCK = 256
"""Samples in a row that are summed at once."""
_PLACE = 3e-13
"""What rounding of the time between samples makes of a block [s]: no road is so fast that it shows."""
_ROUNDING = 1e-15
"""Share of a time that a sum of two differs from it by, in samples that are even."""


def mean_density(road_class: str) -> float:
    """Geometric mean of Gd(n0) of a class [m3]."""
    return 16e-6 * 4.0 ** CLASSES.index(road_class)


@lru_cache(maxsize=32)
def _lines(seed: int, low: float, high: float) -> tuple[Array, Array, Array]:
    """Spatial frequency [cycles/m], amplitude over root Gd(n0) [m^-0.5], phase [rad]; (LINES,)."""
    rng = np.random.default_rng(seed)
    edges = np.geomspace(low, high, LINES + 1)
    n = edges[:-1] * (edges[1:] / edges[:-1]) ** rng.random(LINES)
    power = N_0**2 * (1.0 / edges[:-1] - 1.0 / edges[1:])
    return n, np.sqrt(2.0 * power), rng.uniform(0.0, 2.0 * np.pi, LINES)


def make(s: Mapping[str, Any], t: Array, seed: int) -> Array:
    """Height [m], (n,), zero at t = 0 so that a car can start at rest on it."""
    low, high = s["n_min"], s["n_max"]
    if low >= high:
        raise InputError("road", "n_min", f"less than n_max, {high:g} cycles/m", f"{low:g}")
    n, root, phase = _lines(seed, low, high)
    amplitude = np.sqrt(mean_density(s["road_class"])) * root
    omega = 2.0 * np.pi * n * s["speed"]
    return _sum(amplitude, omega, phase, t) - float(np.sin(phase) @ amplitude)


def _sum(amplitude: Array, omega: Array, phase: Array, t: Array) -> Array:
    """Sum of sines (LINES,) at times t (n,) [s].

    Where samples follow each other evenly every block has the angles of the first one and some more, the same for all
    its samples: by the addition theorem a minute at 2 kHz takes one sine in eighty.
    """
    apart = round(
        float(t[-1] - t[0]) / max(t.size - 1, 1), 15
    )  # the same for every stretch of a road
    begins, height = t[::_BLOCK], np.empty(t.shape)
    even = np.add.outer(begins, apart * np.arange(_BLOCK)).ravel()[: t.size]
    if t.size < _BLOCK // 2 or np.abs(even - t).max() > _ROUNDING * np.abs(t).max() + _PLACE:
        for i in range(0, t.size, _BLOCK):
            height[i : i + _BLOCK] = (
                np.sin(np.multiply.outer(t[i : i + _BLOCK], omega) + phase) @ amplitude
            )
        return height
    turns = _turns(apart, omega.tobytes())
    for i, begin in zip(range(0, t.size, _BLOCK), begins, strict=True):
        angle, some = omega * begin + phase, turns[: t.size - i]
        both = np.concatenate([amplitude * np.sin(angle), amplitude * np.cos(angle)])
        height[i : i + _BLOCK] = some @ both
    return height


@lru_cache(maxsize=4)
def _turns(apart: float, omega: bytes) -> Array:
    """Cosines and sines (_BLOCK, 2 LINES) of the angles that sines of these omega [rad/s] turn by within a block."""
    turned = np.multiply.outer(apart * np.arange(_BLOCK), np.frombuffer(omega))
    return np.hstack([np.cos(turned), np.sin(turned)])


KIND = Kind(
    "iso8608",
    "random road of ISO 8608",
    (
        Text("road_class", "C", "class, A (very good) to H", tuple(CLASSES)),
        Number("speed", "m/s", 60.0 / 3.6, 0.0, 150.0, "speed of the car"),
        Number("n_min", "1/m", 0.011, 1e-4, 100.0, "lowest spatial frequency, in cycles/m"),
        Number("n_max", "1/m", 2.83, 1e-4, 100.0, "highest spatial frequency, in cycles/m"),
    ),
    make,
)
