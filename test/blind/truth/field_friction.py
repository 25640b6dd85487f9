"""Seal that the field presses on the rod: F = N h / (1 + h / h_s) v / sqrt(v^2 + v_e^2).

h is the duty after the chains have formed; the seal stiffens, so that its pressure grows less than in proportion.
"""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import inner


@inner
def force(v: float, h: float, strength: float, stiff: float, width: float) -> float:
    """Friction [N] at velocity v [m/s] and duty h."""
    if strength == 0.0:
        return 0.0
    return float(strength * h / (1.0 + h / stiff) * v / (v * v + width * width) ** 0.5)


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Duty where the seal gives half, and width of the reversal [m/s]."""
    del scene
    return rng.uniform(1.5, 3.0), rng.uniform(1.5e-3, 4e-3)


EFFECT = Effect(
    "field_friction",
    (("N", "N"), ("h_s", "1"), ("v_e", "m/s")),
    4.0,
    0.2,
    20.0,
    draw,
    acts={"friction": force},
)
