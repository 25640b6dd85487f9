"""Friction that falls with speed: exponential of exponent one, arctangent at reversal.

    F = [F_c + (F_s - F_c) exp(-|v| / v_s)] (2 / pi) atan(v / v_e)

The strength is F_s; F_c is a fixed share of it, so that both vanish together.
Source of the law: Armstrong-Helouvry, Dupont and Canudas de Wit 1994, here with exponent one.
"""

from __future__ import annotations

import math

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import inner
from test.blind.slots import STRIBECK


@inner
def force(v: float, strength: float, share: float, decay: float, width: float) -> float:
    """Friction [N] at velocity v [m/s]."""
    if strength == 0.0:
        return 0.0
    level = strength * (share + (1.0 - share) * math.exp(-abs(v) / decay))
    return level * 2.0 / math.pi * math.atan(v / width)


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Share F_c / F_s, decay v_s [m/s] and width v_e [m/s]."""
    del scene
    return rng.uniform(0.15, 0.45), rng.uniform(8e-3, 20e-3), rng.uniform(1.5e-3, 3e-3)


EFFECT = Effect(
    "stribeck_friction",
    (("F_s", "N"), ("F_c/F_s", "1"), ("v_s", "m/s"), ("v_e", "m/s")),
    1.0,
    0.1,
    2.5,
    draw,
    acts={"friction": force},
    slot=STRIBECK,
)
