"""Force of the whole damper while fluid drains through a leak (Torricelli): (1 - s t / 2 T)^2 from a record's start."""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import inner


@inner
def factor(t: float, strength: float, span: float) -> float:
    """What the force of the rod is multiplied by at time t [s]; the strength is the share lost in a span, at first."""
    if strength == 0.0 or t <= 0.0:
        return 1.0
    level = max(1.0 - 0.5 * strength * t / span, 0.0)
    return float(level * level)


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Span [s], by the length of a record."""
    return (scene.seconds * rng.uniform(0.8, 1.2),)


EFFECT = Effect(
    "force_fade", (("s", "1"), ("T", "s")), 0.2, 0.02, 0.6, draw, acts={"whole": factor}
)
