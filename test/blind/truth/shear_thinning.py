"""Carreau fluid instead of a Newtonian one.

The viscous force is multiplied by

    [(1 + (v / v_c)^2) / (1 + (v_r / v_c)^2)]^(-s / 2),   s = 1 - n

so that the fluid is Newtonian below v_c, a power law above it, and equal to the base at v_r.
Source of the law: Carreau 1972.
"""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import inner
from test.blind.slots import THINNING


@inner
def factor(v: float, strength: float, corner: float, reference: float) -> float:
    """What the viscous coefficient is multiplied by at velocity v [m/s]."""
    if strength == 0.0:
        return 1.0
    here = 1.0 + (v / corner) ** 2
    there = 1.0 + (reference / corner) ** 2
    return float((here / there) ** (-0.5 * strength))


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Corner velocity and reference velocity [m/s]."""
    del scene
    return rng.uniform(4e-3, 12e-3), 0.05


EFFECT = Effect(
    "shear_thinning",
    (("1-n", "1"), ("v_c", "m/s"), ("v_r", "m/s")),
    0.25,
    0.02,
    0.45,
    draw,
    most_negative=0.25,
    acts={"viscosity": factor},
    slot=THINNING,
)
