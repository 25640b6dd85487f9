"""Response of the field force that is not one constant lag.

    varying      tau(u) = tau exp[s (u - u_m) / u_m],  u_m = 0.15
    rise, fall   tau is multiplied by exp(s) where the force is shrinking, smoothly

Thesis Table 1.4 has tau growing fourfold from u = 0.1 to 0.3, which is s of about 1.1.
"""

from __future__ import annotations

import math

from test.blind.effect import Effect, nothing
from test.blind.jit import Array, inner
from test.blind.slots import RISE_FALL, VARYING_TAU

_MIDDLE = 0.15


@inner
def time_constant(tau: float, u: float, force: float, target: float, rows: Array) -> float:
    """Time constant [s] at duty u while the field force [N] moves to its target [N]."""
    if rows[VARYING_TAU, 0] != 0.0:
        tau *= math.exp(rows[VARYING_TAU, 0] * (u - _MIDDLE) / _MIDDLE)
    if rows[RISE_FALL, 0] != 0.0:
        shrinking = force * (force - target)
        share = 0.5 * (1.0 + shrinking / (abs(shrinking) + 0.05))
        tau *= math.exp(rows[RISE_FALL, 0] * share)
    return tau


VARYING = Effect("varying_time_constant", (("s", "1"),), 0.9, 0.1, 2.2, nothing, slot=VARYING_TAU)
ASYMMETRY = Effect(
    "rise_fall_asymmetry",
    (("ln(tau_fall/tau_rise)", "1"),),
    0.7,
    0.1,
    2.2,
    nothing,
    most_negative=1.8,
    slot=RISE_FALL,
)
