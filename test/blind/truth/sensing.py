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
from test.blind.slots import DEFLECTION_ZERO, FORCE_DELAY, FORCE_LAG, VELOCITY_LAG


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


DELAY = Effect(
    "force_delay", FORCE_DELAY, (("d", "s"),), 3e-3, 2e-4, 0.018, nothing, most_negative=0.018
)
LAG = Effect("force_lag", FORCE_LAG, (("T", "s"),), 4e-3, 3e-4, 0.04, nothing)
VELOCITY = Effect("velocity_lag", VELOCITY_LAG, (("T", "s"),), 3e-3, 3e-4, 0.04, nothing)
ZERO = Effect(
    "deflection_zero",
    DEFLECTION_ZERO,
    (("x_0", "m"),),
    8e-4,
    1e-4,
    3e-3,
    nothing,
    most_negative=3e-3,
)
