"""Thinning over the measured temperature, worked by hand."""

import math

from worked import PASSIVE, YIELD, Force

WARM = {"b_v": 0.02, "b_y": -0.01}
WORKED = (
    # 20 K: 5 N of viscosity less, 6 N of yield force more
    Force(
        WARM,
        {**PASSIVE, **YIELD},
        v=0.1,
        u=0.3,
        theta=20.0,
        force=5.0 * math.exp(-0.4) + 6.0 * math.exp(0.2),
    ),
)
