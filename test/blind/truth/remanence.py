"""Iron that stays magnetised: Dahl's law in the field instead of in the travel (Coleman and Hodgdon 1986).

    w' = -h' - |h'| w / d,   field = duty + s w / d

While the field h rises w tends to -d, while it falls to +d.
"""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene, between
from test.blind.jit import inner


@inner
def rate(w: float, change: float, strength: float, width: float) -> float:
    """Rate [1/s] of what is remembered, while the field changes at a rate [1/s]."""
    return -change - abs(change) * w / width if strength != 0.0 else 0.0


@inner
def field(u: float, w: float, strength: float, width: float) -> float:
    """Duty that the field stands for."""
    return u + strength * w / width if strength != 0.0 else u


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Change of the duty [1] that turns the iron round."""
    del scene
    return (between(rng, 0.01, 0.03),)


EFFECT = Effect(
    "remanence",
    (("s", "1"), ("d", "1")),
    0.02,
    0.003,
    0.1,
    draw,
    acts={"rate": rate, "field": field},
)
