"""Friction of a one-sided seal: F (2 / pi) atan(v / v_e) in rebound, a share of it in compression."""

from __future__ import annotations

import math

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import inner


@inner
def force(v: float, strength: float, share: float, width: float) -> float:
    """Friction [N] at velocity v [m/s]."""
    if strength == 0.0:
        return 0.0
    return strength * (1.0 if v > 0.0 else share) * 2.0 / math.pi * math.atan(v / width)


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Share in compression, and width of the reversal [m/s]."""
    del scene
    share = rng.uniform(0.15, 0.5)
    return (share if rng.random() < 0.5 else 1.0 / share), rng.uniform(1.0e-3, 2.5e-3)


EFFECT = Effect(
    "directional_friction",
    (("F", "N"), ("q", "1"), ("v_e", "m/s")),
    0.8,
    0.05,
    3.0,
    draw,
    acts={"friction": force},
)
