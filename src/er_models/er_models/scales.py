"""Natural scales: what is large for this damper, from its data or its model.

Bounds and starting values of all parameters are multiples of these, so that nothing in the library
is tied to the size of one rig.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from er_models.errors import InputError


def peak(y: NDArray[np.float64]) -> float:
    """Robust peak of a signal (n,) about its middle, in its unit; above zero."""
    return float(max(np.quantile(np.abs(y - np.median(y)), 0.995), 1e-9))


@dataclass(frozen=True, slots=True)
class Scales:
    """Envelope of use: force [N], deflection [m], velocity [m/s], duty [1]; all positive."""

    force: float
    deflection: float
    velocity: float
    duty: float

    @property
    def acceleration(self) -> float:
        """Acceleration of a sine with this deflection and velocity [m/s2]."""
        return self.velocity**2 / self.deflection

    def of(self, unit: str) -> float:
        """Natural scale of a unit, e.g. ``N s/m`` -> force / velocity."""
        f, x, v = self.force, self.deflection, self.velocity
        table = {
            "1": 1.0, "s": 1.0, "K": 1.0, "1/K": 1.0, "1/s": 1.0,
            "N": f, "m": x, "m/s": v, "duty": self.duty, "1/duty": 1.0 / self.duty,
            "N/m": f / x, "N s/m": f / v, "N/m2": f / x**2, "N/m3": f / x**3,
            "N s2/m2": f / v**2, "N s/m3": f / (v * x**2), "kg": f / self.acceleration,
            "1/duty2": 1.0 / self.duty**2, "s/duty": 1.0 / self.duty, "s/duty2": 1.0 / self.duty**2,
            "1/m": 1.0 / x, "s/m": 1.0 / v, "m/N": x / f, "1/W": 1.0 / (f * v),
            "N/duty": f / self.duty, "N s/m/duty": f / v / self.duty, "N/m/duty": f / x / self.duty,
            "m/s2": self.acceleration, "W": f * v,
        }  # fmt: skip
        if unit not in table:
            raise InputError("parameter", "unit", f"one of {', '.join(table)}", unit)
        return table[unit]
