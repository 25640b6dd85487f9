"""Brake pad that rattles in its holder: Bouc-Wen's bristle with a power above one, behind a gap.

    w' = v - |v| |r|^(n-1) r,   r = [w]_g / z_y,   F = a r,   [w]_g what of w is beyond the gap +-g

Sources: Wen 1976; Nordin and Gutman 2002.
"""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene, between
from test.blind.jit import inner


@inner
def bent(w: float, reach: float, gap: float) -> float:
    """Bend of the bristle over its reach."""
    return (max(w - gap, 0.0) + min(w + gap, 0.0)) / reach


@inner
def rate(w: float, v: float, strength: float, reach: float, gap: float, power: float) -> float:
    """Rate of gap and bristle together [m/s]."""
    if strength == 0.0:
        return 0.0
    r = bent(w, reach, gap)
    return float(v - abs(v) * abs(r) ** (power - 1.0) * r)


@inner
def force(w: float, strength: float, reach: float, gap: float, power: float) -> float:
    """Force [N] of the bristle."""
    if strength == 0.0:
        return 0.0
    return strength * bent(w, reach, gap)


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Reach z_y [m], gap [m] by the stroke in use, and power."""
    gap = float(np.std(scene.deflection)) * rng.uniform(0.1, 0.3)
    return between(rng, 0.3e-3, 0.9e-3), gap, rng.uniform(1.2, 1.8)


EFFECT = Effect(
    "friction_with_play",
    (("a", "N"), ("z_y", "m"), ("g", "m"), ("n", "1")),
    0.8,
    0.05,
    4.0,
    draw,
    acts={"rate": rate, "friction": force},
)
