"""Vapour behind the piston in fast compression: the fluid cannot pull harder than F_cav.

With h the force of the filled damper and w the void [m of stroke],

    w' = (-F_cav - h) / c_0  while a void exists or h < -F_cav
    F  = h + (-F_cav - h) w / (w + w_s)  while a void exists

so that the force stays at the vapour level until the stroke has closed the void: the refill lag.
F_cav = F_r (1 - s) with F_r the largest pull in the undisturbed motion; s is the strength.
"""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import inner
from test.blind.slots import CAVITATION


@inner
def rate(h: float, w: float, viscosity: float, strength: float, reference: float) -> float:
    """Growth of the void [m/s] under the filled force h [N]."""
    if strength == 0.0:
        return 0.0
    growth = (-reference * (1.0 - strength) - h) / viscosity
    return growth if (w > 0.0 or growth > 0.0) else 0.0


@inner
def limited(h: float, w: float, strength: float, reference: float, small: float) -> float:
    """Force [N] that is left of the filled force h [N] with a void w [m]."""
    if strength == 0.0 or w <= 0.0:
        return h
    return h + (-reference * (1.0 - strength) - h) * w / (w + small)


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Largest pull [N] and the void at which the vapour level is half reached [m]."""
    return float(-np.min(scene.hydraulic)), rng.uniform(1e-5, 3e-5)


EFFECT = Effect(
    "cavitation",
    (("s", "1"), ("F_r", "N"), ("w_s", "m")),
    0.45,
    0.05,
    0.9,
    draw,
    slot=CAVITATION,
)
