"""From the duty asked for to the field: dead time, amplifier, dead band, field law.

dead time   u(t - T_d)
amplifier   T a_1' + a_1 = u, then 0.15 T a_2' + a_2 = a_1
dead band   [d + sqrt(d^2 + e^2)] / 2 less its value at zero, d = u - u_0, e = 0.003
field law   u [(1 - s) + s u / u_r] for s > 0 (polarisation grows with the square of the field),
            (1 + s) u - s sqrt(u u_r) for s < 0 (conduction saturates)
"""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene, nothing
from test.blind.jit import Array, inner
from test.blind.slots import AMPLIFIER, DEAD_BAND, DEAD_TIME, EXPONENT

_EDGE = 0.003


@inner
def beyond_dead_band(u: float, rows: Array) -> float:
    """Duty that is left of u."""
    start = rows[DEAD_BAND, 0]
    if start == 0.0:
        return float(u)
    d = u - start
    rest = (start * start + _EDGE * _EDGE) ** 0.5 - start
    return float(0.5 * (d + (d * d + _EDGE * _EDGE) ** 0.5 - rest))


@inner
def field(u: float, s: float, reference: float) -> float:
    """Field, as an equivalent duty, that a steady duty u makes."""
    if s > 0.0:
        return float(u * (1.0 - s + s * u / reference))
    if s < 0.0:
        return float((1.0 + s) * u - s * (max(u, 0.0) * reference) ** 0.5)
    return float(u)


def draw_exponent(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Duty at which the law crosses the straight line."""
    del scene
    return (rng.uniform(0.18, 0.3),)


DELAY = Effect("dead_time", (("T_d", "s"),), 8e-3, 1e-3, 0.03, nothing, slot=DEAD_TIME)
LAG = Effect("amplifier_lag", (("T", "s"),), 8e-3, 1e-3, 0.04, nothing, slot=AMPLIFIER)
BAND = Effect("duty_dead_band", (("u_0", "1"),), 0.03, 4e-3, 0.09, nothing, slot=DEAD_BAND)
LAW = Effect(
    "field_exponent",
    (("s", "1"), ("u_r", "1")),
    0.35,
    0.03,
    1.0,
    draw_exponent,
    most_negative=0.8,
    acts={"field": field},
    slot=EXPONENT,
)
