"""Iron that keeps its field until the duty has gone a way of r beyond it, and follows then within T, for eddy currents.

    T w' = [u - w]_r,   field = (1 - s) u + s w,   [.]_r what is beyond +-r

Sources: Bertotti 1998 (coercivity and eddy currents).
"""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import inner


@inner
def rate(u: float, w: float, strength: float, reach: float, follows: float) -> float:
    """Rate of the iron's field [1/s]."""
    if strength == 0.0:
        return 0.0
    return (max(u - w - reach, 0.0) + min(u - w + reach, 0.0)) / follows


@inner
def field(u: float, w: float, strength: float, reach: float, follows: float) -> float:
    """Duty that the whole field stands for."""
    return u + strength * (w - u)


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Duty r that turns the iron, of up to 0.3, and time T in which it follows [s]."""
    del scene
    return rng.uniform(0.02, 0.06), rng.uniform(1e-3, 4e-3)


EFFECT = Effect(
    "remanence",
    (("s", "1"), ("r", "1"), ("T", "s")),
    0.5,
    0.05,
    1.0,
    draw,
    acts={"rate": rate, "field": field},
)
