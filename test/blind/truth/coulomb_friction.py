"""Dry friction of seals with an algebraic regularisation, F = F_c v / sqrt(v^2 + v_e^2)."""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import inner
from test.blind.slots import COULOMB


@inner
def force(v: float, strength: float, width: float) -> float:
    """Friction [N] at velocity v [m/s]."""
    if strength == 0.0:
        return 0.0
    return float(strength * v / (v * v + width * width) ** 0.5)


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Width of the reversal [m/s]."""
    del scene
    return (rng.uniform(1.5e-3, 4e-3),)


EFFECT = Effect(
    "coulomb_friction",
    (("F_c", "N"), ("v_e", "m/s")),
    0.6,
    0.05,
    2.0,
    draw,
    acts={"friction": force},
    slot=COULOMB,
)
