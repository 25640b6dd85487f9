"""Pressure that the duty commands, on the area of the rod: F = A h / sqrt(1 + (h / h_s)^2), the supply soon exhausted.

h is the duty after the chains have formed.
"""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import inner


@inner
def force(h: float, strength: float, exhausted: float) -> float:
    """Force [N] at the duty h."""
    if strength == 0.0:
        return 0.0
    return float(strength * h / (1.0 + (h / exhausted) ** 2) ** 0.5)


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Duty from which on the supply gives way; duties go up to 0.3."""
    del scene
    return (rng.uniform(0.8, 1.6),)


EFFECT = Effect(
    "field_preload",
    (("A", "N"), ("h_s", "1")),
    4.0,
    0.2,
    60.0,
    draw,
    most_negative=60.0,
    acts={"elastic": force},
)
