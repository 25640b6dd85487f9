"""Half of what a one-sided seal rubs more in one direction than in the other: F |v| / sqrt(v^2 + v_e^2)."""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import inner


@inner
def force(v: float, strength: float, width: float) -> float:
    """Friction [N] at velocity v [m/s]."""
    if strength == 0.0:
        return 0.0
    return float(strength * abs(v) / (v * v + width * width) ** 0.5)


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Width of the reversal [m/s]."""
    del scene
    return (rng.uniform(2.5e-3, 5e-3),)


EFFECT = Effect(
    "directional_friction",
    (("F", "N"), ("v_e", "m/s")),
    0.8,
    0.05,
    3.0,
    draw,
    most_negative=3.0,
    acts={"friction": force},
)
