"""Positions of a slider over the bounds of a parameter: fine where values are small, which is where they mostly are."""

from __future__ import annotations

import math
from dataclasses import dataclass

POSITIONS = 2000
"""Positions of a slider."""
WIDE = 100.0
"""Ratio of positive bounds from which equal steps are equal ratios."""


@dataclass(frozen=True)
class Slider:
    """Positions 0 to `POSITIONS` from the lower to the upper bound [SI]."""

    low: float
    high: float

    def position(self, value: float) -> float:
        """Where a value stands."""
        a, b, v = (
            self._even(x) for x in (self.low, self.high, min(max(value, self.low), self.high))
        )
        return POSITIONS * (v - a) / (b - a)

    def value(self, position: float) -> float:
        """The value at a position to six digits, within the bounds."""
        a, b = self._even(self.low), self._even(self.high)
        even = a + (b - a) * position / POSITIONS
        found = (
            math.exp(even) if self._logarithmic else even * abs(even) if self._about_zero else even
        )
        return min(max(float(f"{found:.6g}"), self.low), self.high)

    @property
    def _logarithmic(self) -> bool:
        return self.low > 0.0 and self.high / self.low > WIDE

    @property
    def _about_zero(self) -> bool:
        return self.low <= 0.0 <= self.high

    def _even(self, value: float) -> float:
        """What a slider is even in: logarithm, signed root where zero is within the bounds, else the value."""
        if self._logarithmic:
            return math.log(value)
        return math.copysign(math.sqrt(abs(value)), value) if self._about_zero else value
