"""What the tyre does beyond a spring.

tyre_damping   a standard linear solid: a spring in series with a dashpot beside the tyre's own, tau r' = z' - r / tau
tyre_lift_off  the contact force N = W - k_t z ends softly at zero, N -> (N + sqrt(N^2 + (W / 50)^2)) / 2
"""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene, nothing
from test.blind.jit import Array, inner
from test.blind.slots import KT, MS, MU, TYRE_DAMPING, TYRE_LIFT

_GRAVITY = 9.81
_CORNER = 0.02


@inner
def force(z: float, lag: float, rows: Array, masses: Array) -> float:
    """Force of the tyre on the wheel [N], downwards, at its height z over the road [m]; lag: dashpot's travel."""
    total = masses[KT] * z
    if rows[TYRE_DAMPING, 0] != 0.0:
        total += rows[TYRE_DAMPING, 0] / rows[TYRE_DAMPING, 1] * (z - lag)
    if rows[TYRE_LIFT, 0] != 0.0:
        weight = (masses[MS] + masses[MU]) * _GRAVITY / rows[TYRE_LIFT, 0]
        contact, corner = weight - total, _CORNER * weight
        total = weight - 0.5 * (contact + (contact * contact + corner * corner) ** 0.5)
    return float(total)


@inner
def rate(z: float, lag: float, rows: Array) -> float:
    """Rate of the dashpot's travel [m/s]."""
    if rows[TYRE_DAMPING, 0] == 0.0:
        return 0.0
    return float((z - lag) / rows[TYRE_DAMPING, 1])


def draw_time(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Time of the dashpot [s], short against the wheel's resonance."""
    del scene
    return (rng.uniform(0.5e-3, 1e-3),)


DAMPING = Effect(
    "tyre_damping",
    (("c_t", "N.s/m"), ("tau", "s")),
    10.0,
    5.0,
    20.0,
    draw_time,
    shown_by_force=False,
    slot=TYRE_DAMPING,
)
LIFT = Effect(
    "tyre_lift_off",
    (("lightness", "1"),),
    2.4,
    2.0,
    2.8,
    nothing,
    shown_by_force=False,
    slot=TYRE_LIFT,
)
