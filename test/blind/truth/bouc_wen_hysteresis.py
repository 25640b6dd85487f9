"""Pre-sliding hysteresis: LuGre with a constant sliding level, or Bouc-Wen with a power above one.

    LuGre      z' = v - |v| z / z_y,                       F = a z / z_y + s_1 z'
    Bouc-Wen   z' = v - b |v| |r|^(n-1) r - (1 - b) v |r|^n,  r = z / z_y,   F = a r

Sources: Canudas de Wit et al. 1995 (LuGre); Wen 1976.
"""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene, between
from test.blind.jit import inner
from test.blind.slots import HYSTERESIS


@inner
def rate(
    w: float, v: float, strength: float, reach: float, wen: float, power: float, share: float
) -> float:
    """Rate of the bristle deflection w [m/s]."""
    if strength == 0.0:
        return 0.0
    r = w / reach
    if wen < 0.5:
        return v - abs(v) * r
    grown = abs(r) ** (power - 1.0)
    return float(v - share * abs(v) * grown * r - (1.0 - share) * v * grown * abs(r))


@inner
def force(
    w: float,
    v: float,
    strength: float,
    reach: float,
    wen: float,
    power: float,
    share: float,
    micro: float,
) -> float:
    """Force [N] from the bristle deflection w [m] and its rate."""
    if strength == 0.0:
        return 0.0
    slip = rate(w, v, strength, reach, wen, power, share)
    return strength * w / reach + micro * strength * slip


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Reach z_y [m], law, power n, share b, and micro damping over a [s/m]."""
    del scene
    wen = float(rng.random() < 0.5)
    micro = 0.0 if wen else rng.uniform(1.0, 4.0)
    return between(rng, 0.25e-3, 0.9e-3), wen, rng.uniform(1.3, 2.0), rng.uniform(0.5, 0.8), micro


EFFECT = Effect(
    "bouc_wen_hysteresis",
    (("a", "N"), ("z_y", "m"), ("wen", "1"), ("n", "1"), ("b", "1"), ("s_1/a", "s/m")),
    0.8,
    0.05,
    2.5,
    draw,
    acts={"rate": rate, "friction": force},
    slot=HYSTERESIS,
)
