"""Iron that stays magnetised: Dahl's law in the field instead of in the travel (Coleman and Hodgdon 1986).

    w' = -h' - |h'| w / (q s),   field = duty + w / q

While the field h rises w tends to -q s, while it falls to +q s. With q of two and more no loop has a slope below zero.
"""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import inner


@inner
def rate(w: float, change: float, strength: float, slow: float) -> float:
    """Rate [1/s] of what is remembered, while the field changes at a rate [1/s]."""
    return -change - abs(change) * w / (slow * strength) if strength != 0.0 else 0.0


@inner
def field(u: float, w: float, strength: float, slow: float) -> float:
    """Duty that the field stands for."""
    return u + w / slow if strength != 0.0 else u


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Change of the duty that turns the iron round, over the strength."""
    del scene
    return (rng.uniform(2.0, 3.0),)


EFFECT = Effect(
    "remanence",
    (("s", "1"), ("q", "1")),
    0.02,
    0.003,
    0.04,
    draw,
    acts={"rate": rate, "field": field},
)
