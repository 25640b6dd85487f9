"""Orifice loss with a laminar core, F = c_2 v [sqrt(v^2 + v_t^2) - v_t].

Quadratic above the transition velocity v_t and cubic below it, without the kink of v |v|.
"""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import inner
from test.blind.slots import QUADRATIC


@inner
def force(v: float, strength: float, transition: float) -> float:
    """Force [N] at velocity v [m/s]."""
    if strength == 0.0:
        return 0.0
    return float(strength * v * ((v * v + transition * transition) ** 0.5 - transition))


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Transition velocity [m/s]."""
    del scene
    return (rng.uniform(3e-3, 12e-3),)


EFFECT = Effect(
    "quadratic_damping",
    (("c_2", "N.s2/m2"), ("v_t", "m/s")),
    200.0,
    20.0,
    1200.0,
    draw,
    acts={"fluid": force},
    slot=QUADRATIC,
)
