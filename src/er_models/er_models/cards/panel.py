"""What a picture is made of: curves in panels, and the damper and sampling that all pictures share."""

from __future__ import annotations

from dataclasses import dataclass

from er_models.model import Array
from er_models.scales import Scales

SCALES = Scales(force=20.0, deflection=0.010, velocity=0.15, duty=0.3)
DT = 0.005
"""Step of the motions that are drawn [s]; nothing but the pictures follows it."""
CYCLES = 2
"""Cycles shown, the last ones: slow effects have come by then."""
WITHOUT, WITH, CHANGE = "#9a9a9a", "#1f6fb4", "#c8432b"
"""Colours of a signal without the effect, with it, and of the difference."""


@dataclass(frozen=True)
class Curve:
    """One line of a picture: points (n,) each, and its colour."""

    x: Array
    y: Array
    colour: str


@dataclass(frozen=True)
class Panel:
    """Axis labels with units, and curves."""

    x_label: str
    y_label: str
    curves: tuple[Curve, ...]
