"""Particle chains that add viscosity and stiffness, F = c_u h v + k_u h x / sqrt(1 + (x / x_s)^2).

h is the duty after the chains have formed, tau h' + h = u: the structure needs the same time as
the yield force, and it tears beyond x_s.
"""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene, nothing
from test.blind.jit import inner
from test.blind.slots import FIELD_STIFFNESS, FIELD_VISCOSITY


@inner
def viscous(v: float, h: float, strength: float) -> float:
    """Force [N] of the field's viscosity."""
    return strength * h * v


@inner
def elastic(x: float, h: float, strength: float, tear: float) -> float:
    """Force [N] of the field's stiffness."""
    if strength == 0.0:
        return 0.0
    return float(strength * h * x / (1.0 + (x / tear) ** 2) ** 0.5)


def draw_stiffness(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Deflection where the chains tear [m], by the stroke in use."""
    return (float(np.max(np.abs(scene.deflection))) * rng.uniform(1.5, 3.0),)


VISCOSITY = Effect(
    "field_viscosity",
    (("c_u", "N.s/m"),),
    60.0,
    5.0,
    900.0,
    nothing,
    acts={"fluid": viscous},
    slot=FIELD_VISCOSITY,
)
STIFFNESS = Effect(
    "field_stiffness",
    (("k_u", "N/m"), ("x_s", "m")),
    1200.0,
    100.0,
    15000.0,
    draw_stiffness,
    acts={"elastic": elastic},
    slot=FIELD_STIFFNESS,
)
