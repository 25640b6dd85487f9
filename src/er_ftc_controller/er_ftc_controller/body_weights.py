"""Weights of the body controller, for its synthesis and for its gain file."""

from __future__ import annotations

import math
from dataclasses import dataclass

from er_models.errors import InputError

FORGET = 0.5
"""Rate at which a tyre's deflection by the road is forgotten [1/s]: no force drives a twisted road out."""


@dataclass(frozen=True)
class BodyWeights:
    """Sizes that count as one: accelerations [m/s2, rad/s2], deflection and tyre deflection [m], yield force [N]."""

    heave: float
    roll: float
    pitch: float
    deflection: float
    tyre: float
    force: float

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not 0.0 < value < math.inf:
                raise InputError("weights", name, "a number above 0", f"{value:g}")
