"""Springs in series with dashpots: a two-term Prony series in the dashpots' own travel y.

y_i' = (x - y_i) / t_i,   F = k_m [(1 - q) (x - y_1) + q (x - y_2)],   t_2 = t_1 / 4
"""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene, between
from test.blind.jit import inner
from test.blind.slots import VISCOELASTIC


@inner
def force(x: float, y1: float, y2: float, strength: float, share: float) -> float:
    """Force [N] at deflection x [m] with dashpot travels y1, y2 [m]."""
    if strength == 0.0:
        return 0.0
    return strength * ((1.0 - share) * (x - y1) + share * (x - y2))


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Share of the faster branch and the slower time constant [s]."""
    del scene
    return rng.uniform(0.0, 0.25), between(rng, 0.03, 0.1)


EFFECT = Effect(
    "viscoelastic_branch",
    (("k_m", "N/m"), ("q", "1"), ("t_1", "s")),
    300.0,
    20.0,
    1500.0,
    draw,
    slot=VISCOELASTIC,
)
