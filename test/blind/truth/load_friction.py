"""Leaves of a spring that rub on one another: F = mu (N_0 + k [x - x_f]_+) v / sqrt(v^2 + v_e^2).

The leaves touch from a deflection x_f on, softly, [z]_+ = w ln(1 + exp(z / w)), and the clamp presses them by N_0.
"""

from __future__ import annotations

import math

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import inner


@inner
def force(
    x: float, v: float, strength: float, clamp: float, free: float, soft: float, width: float
) -> float:
    """Friction [N] at deflection x [m] and velocity v [m/s]; strength [N/m], clamp [m]."""
    if strength == 0.0:
        return 0.0
    z = x - free
    load = clamp + max(z, 0.0) + soft * math.log1p(math.exp(-abs(z) / soft))
    return float(strength * load * v / (v * v + width * width) ** 0.5)


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Clamp [m] of deflection, deflection where the leaves touch, its softness [m], width of the reversal [m/s]."""
    most = float(np.max(np.abs(scene.deflection)))
    return (
        rng.uniform(0.0, 0.1) * most,
        rng.uniform(-1.2, -0.9) * most,
        0.1 * most,
        rng.uniform(2e-3, 4e-3),
    )


EFFECT = Effect(
    "load_friction",
    (("mu k", "N/m"), ("N_0 / k", "m"), ("x_f", "m"), ("w", "m"), ("v_e", "m/s")),
    100.0,
    10.0,
    400.0,
    draw,
    acts={"friction": force},
)
