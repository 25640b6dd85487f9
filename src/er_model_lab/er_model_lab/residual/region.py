"""A range of one quantity, and how much of the error lies in it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Region:
    """Share of the squared error over a range of one quantity; rms error [N] with its 90 % band.

    floor: rms of the noise there; excess: root of what the mean square exceeds the noise by, with its 90 % band.
    Bands are of a block bootstrap.
    """

    quantity: str
    unit: str
    edges: tuple[float, float]
    share: float
    of_samples: float
    rms: float
    band: tuple[float, float]
    floor: float = 0.0
    excess: float = 0.0
    excess_band: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class RegionTable:
    """Error against one quantity, bin by bin."""

    quantity: str
    unit: str
    regions: tuple[Region, ...]
