"""Yield force that fades while particles settle, 1 / (1 + s (t / T)^m) from a record's start."""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import inner
from test.blind.slots import FADE


@inner
def factor(t: float, strength: float, span: float, power: float) -> float:
    """What the yield force is multiplied by at time t [s]."""
    if strength == 0.0 or t <= 0.0:
        return 1.0
    return float(1.0 / (1.0 + strength * (t / span) ** power))


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Span [s], by the length of a record, and power."""
    return scene.seconds * rng.uniform(0.8, 1.2), rng.uniform(0.85, 1.1)


EFFECT = Effect(
    "effectiveness_fade",
    (("s", "1"), ("T", "s"), ("m", "1")),
    0.3,
    0.03,
    0.8,
    draw,
    acts={"yield_force": factor},
    slot=FADE,
)
