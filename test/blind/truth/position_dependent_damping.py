"""Damping that grows away from mid-stroke, F = c_p v r / (1 + r / 2) with r = (x / x_r)^2.

A tapered gap: quadratic near the middle, saturating at twice c_p far from it.
"""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import inner
from test.blind.slots import POSITION


@inner
def force(x: float, v: float, strength: float, length: float) -> float:
    """Force [N] at deflection x [m] and velocity v [m/s]."""
    if strength == 0.0:
        return 0.0
    r = (x / length) ** 2
    return strength * v * r / (1.0 + 0.5 * r)


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Length of the taper [m], by the stroke in use."""
    return (float(np.max(np.abs(scene.deflection))) * rng.uniform(0.7, 1.1),)


EFFECT = Effect(
    "position_dependent_damping",
    (("c_p", "N.s/m"), ("x_r", "m")),
    40.0,
    2.0,
    600.0,
    draw,
    acts={"fluid": force},
    slot=POSITION,
)
