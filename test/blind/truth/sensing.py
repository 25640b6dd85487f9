"""What the instruments do to motion and force, on the fine grid before sampling.

force_delay      F(t - d); negative where the force clock runs ahead
force_lag        T F_m' + F_m = F
velocity_lag     two lags in series, T and 0.2 T
deflection_zero  x + x_0
"""

from __future__ import annotations

import math

from test.blind.effect import Effect, nothing
from test.blind.jit import Array, entry
from test.blind.slots import DEFLECTION_ZERO, FORCE_DELAY, FORCE_LAG, OF, OV, OX, VELOCITY_LAG


@entry
def lagged(signal: Array, step: float, lag: float) -> Array:
    """First-order lag [s] of a finely sampled signal (n,), exact if straight within a step."""
    out = signal.copy()
    keep = math.exp(-step / lag)
    ramp = lag / step * (1.0 - keep)
    for j in range(1, signal.size):
        rise = signal[j] - signal[j - 1]
        out[j] = keep * out[j - 1] + (1.0 - keep) * signal[j - 1] + (1.0 - ramp) * rise
    return out


def late_force(shown: Array, step: float, lag: float) -> None:
    """The force of the load cell."""
    shown[:, OF] = lagged(shown[:, OF], step, lag)


def late_velocity(shown: Array, step: float, lag: float) -> None:
    """The velocity of the sensor."""
    shown[:, OV] = lagged(lagged(shown[:, OV], step, lag), step, 0.2 * lag)


def off_zero(shown: Array, step: float, zero: float) -> None:
    """The deflection of the sensor."""
    del step
    shown[:, OX] += zero


DELAY = Effect(
    "force_delay", (("d", "s"),), 3e-3, 2e-4, 0.018, nothing, most_negative=0.018, slot=FORCE_DELAY
)
LAG = Effect(
    "force_lag",
    (("T", "s"),),
    4e-3,
    3e-4,
    0.04,
    nothing,
    acts={"shown": late_force},
    slot=FORCE_LAG,
)
VELOCITY = Effect(
    "velocity_lag",
    (("T", "s"),),
    3e-3,
    3e-4,
    0.04,
    nothing,
    acts={"shown": late_velocity},
    slot=VELOCITY_LAG,
)
ZERO = Effect(
    "deflection_zero",
    (("x_0", "m"),),
    8e-4,
    1e-4,
    3e-3,
    nothing,
    most_negative=3e-3,
    acts={"shown": off_zero},
    slot=DEFLECTION_ZERO,
)
