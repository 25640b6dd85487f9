"""What acts between body and wheel beside the damper, and the body itself.

guide_friction       F (2 / pi) atan(v / v_e): bushings and ball joints
spring_nonlinearity  k_s (sinh(l x) / l - x): coils that come to lie on one another
sprung_mass_error    m_s (1 + e)
"""

from __future__ import annotations

import math

import numpy as np

from test.blind.effect import Effect, Scene, nothing
from test.blind.jit import Array, inner
from test.blind.slots import GUIDE, KS, MASS, MS, SPRING


@inner
def beside(x: float, v: float, rows: Array, masses: Array) -> float:
    """Force between the masses beside spring and damper [N]."""
    total = 0.0
    if rows[GUIDE, 0] != 0.0:
        total += rows[GUIDE, 0] * 2.0 / math.pi * math.atan(v / rows[GUIDE, 1])
    if rows[SPRING, 0] != 0.0:
        total += masses[KS] * (math.sinh(rows[SPRING, 0] * x) / rows[SPRING, 0] - x)
    return total


@inner
def body(rows: Array, masses: Array) -> float:
    """Mass of the body [kg]."""
    return float(masses[MS] * (1.0 + rows[MASS, 0]))


def draw_width(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Width of the reversal [m/s]."""
    del scene
    return (rng.uniform(1.5e-3, 4e-3),)


FRICTION = Effect(
    "guide_friction",
    (("F_g", "N"), ("v_e", "m/s")),
    0.8,
    0.3,
    1.5,
    draw_width,
    shown_by_force=False,
    slot=GUIDE,
)
STIFFENING = Effect(
    "spring_nonlinearity",
    (("l", "1/m"),),
    120.0,
    80.0,
    200.0,
    nothing,
    shown_by_force=False,
    slot=SPRING,
)
LOAD = Effect(
    "sprung_mass_error",
    (("e", "1"),),
    0.1,
    0.04,
    0.25,
    nothing,
    most_negative=0.2,
    shown_by_force=False,
    slot=MASS,
)
