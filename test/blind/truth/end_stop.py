"""Bump rubber at both ends: Hertz contact with the loss of Hunt and Crossley 1975.

    F = k_h d^(3/2) (1 + a v_in) sgn x,   d = |x| - x_b > 0,   v_in = v sgn x

never pulling. The gap x_b is set from the motion so that the rubber is really touched.
"""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import inner
from test.blind.slots import END_STOP


@inner
def force(x: float, v: float, strength: float, gap: float, loss: float) -> float:
    """Force [N] at deflection x [m] and velocity v [m/s]."""
    if strength == 0.0:
        return 0.0
    depth = abs(x) - gap
    if depth <= 0.0:
        return 0.0
    sign = 1.0 if x > 0.0 else -1.0
    return float(sign * strength * depth**1.5 * max(0.0, 1.0 + loss * v * sign))


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Gap [m] where 6 to 15 % of the free motion lies beyond, and loss [s/m]."""
    share = rng.uniform(0.85, 0.94)
    return float(np.quantile(np.abs(scene.deflection), share)), rng.uniform(0.5, 2.0)


EFFECT = Effect(
    "end_stop",
    (("k_h", "N/m1.5"), ("x_b", "m"), ("a", "s/m")),
    3e4,
    2e3,
    3e6,
    draw,
    acts={"elastic": force},
    slot=END_STOP,
)
