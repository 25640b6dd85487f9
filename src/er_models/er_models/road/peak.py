"""Scales a road to a given peak of the deflection velocity of the passive car."""

from __future__ import annotations

import numpy as np

from er_models.errors import InputError
from er_models.model import Model
from er_models.simulation import simulate
from er_models.spec import Array

_TRIES = 12
_CLOSE = 1e-3
"""Relative error of the peak that is close enough."""


def factor_for_peak_velocity(
    model: Model, road: Array, dt: float, peak: float, lines: int = 1
) -> float:
    """Factor on a road (n,) for a peak |deflection velocity| at zero duty of `peak` [m/s].

    lines: of the road in a sample of dt [s].

    Exact at once where the passive car is linear; corrected by repetition where an effect bends
    it. Raises `InputError` when the road does not move the car or the peak cannot be reached.
    """
    factor, found, zero = 1.0, 0.0, np.zeros((road.shape[0] - 1) // lines + 1)
    for _ in range(_TRIES):
        motion = simulate(model, dt, factor * road, zero)["deflection_velocity"]
        found = float(np.max(np.abs(motion)))
        if not np.isfinite(found) or found <= 1e-12:
            raise InputError(
                "road", "peak_velocity", "a road that moves the car", f"peak {found:g} m/s"
            )
        if abs(found / peak - 1.0) < _CLOSE:
            return factor
        factor *= peak / found
    raise InputError("road", "peak_velocity", f"{peak:g} m/s to be reachable", f"{found:g} m/s")
