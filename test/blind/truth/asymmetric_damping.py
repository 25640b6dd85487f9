"""Other damping in rebound than in compression: a check valve that opens within a few mm/s.

    F = c_a w ln[1 + exp(v / w)]   (softplus, c_a v in rebound and nothing in compression)

less its value at rest; half of c_a v is absorbed by the base's viscous term.
"""

from __future__ import annotations

import math

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import inner
from test.blind.slots import ASYMMETRIC


@inner
def force(v: float, strength: float, width: float) -> float:
    """Force [N] at velocity v [m/s]."""
    if strength == 0.0:
        return 0.0
    r = abs(v) / width
    softplus = max(v, 0.0) + width * math.log1p(math.exp(-r))
    return strength * (softplus - width * math.log(2.0))


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Width of the opening [m/s]."""
    del scene
    return (rng.uniform(0.5e-3, 2e-3),)


EFFECT = Effect(
    "asymmetric_damping",
    (("c_a", "N.s/m"), ("w", "m/s")),
    20.0,
    1.0,
    50.0,
    draw,
    most_negative=30.0,
    acts={"fluid": force},
    slot=ASYMMETRIC,
)
