"""Two spring-loaded valves beside the orifice, one a direction, whose lift grows with the pressure.

    F = c [L(v - v_e) - q L(-v - v_c)],   L(z) = w ln[1 + exp(z / w)],   less its value at rest

c < 0 is a valve that gives way beyond its knee, c > 0 one behind which the way is narrow.
"""

from __future__ import annotations

import math

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import inner


@inner
def lift(z: float, width: float) -> float:
    """Softplus of width w [m/s]: zero far below the knee, z far beyond."""
    return float(max(z, 0.0) + width * math.log1p(math.exp(-abs(z) / width)))


@inner
def force(v: float, strength: float, up: float, down: float, ratio: float, width: float) -> float:
    """Force [N] at velocity v [m/s]."""
    if strength == 0.0:
        return 0.0
    moving = lift(v - up, width) - ratio * lift(-v - down, width)
    return strength * (moving - lift(-up, width) + ratio * lift(-down, width))


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Knees in rebound and compression [m/s], the other valve's slope over the first's, and width [m/s]."""
    del scene
    ratio = rng.uniform(0.5, 1.5)
    return rng.uniform(0.03, 0.06), rng.uniform(0.02, 0.05), ratio, rng.uniform(1e-3, 3e-3)


EFFECT = Effect(
    "blow_off_valve",
    (("c", "N.s/m"), ("v_e", "m/s"), ("v_c", "m/s"), ("q", "1"), ("w", "m/s")),
    30.0,
    2.0,
    150.0,
    draw,
    most_negative=35.0,
    acts={"fluid": force},
)
