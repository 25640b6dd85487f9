"""Constant force of a pressurised chamber, F = F_0. It also shifts where the car comes to rest."""

from __future__ import annotations

from test.blind.effect import Effect, nothing
from test.blind.slots import PRELOAD

EFFECT = Effect(
    "preload",
    (("F_0", "N"),),
    0.3,
    0.05,
    6.0,
    nothing,
    most_negative=6.0,
    hides_in_bias=True,
    slot=PRELOAD,
)
