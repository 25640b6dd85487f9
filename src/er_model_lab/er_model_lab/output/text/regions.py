"""Which regions of the data carry more of the error than their share."""

from __future__ import annotations

from collections.abc import Sequence

from er_model_lab.output.text.units import discrete
from er_model_lab.residual.region import Region, RegionTable

NOTABLE = 1.3
"""Error over samples from which a region stands out."""
PER_QUANTITY = 2
"""Regions of one quantity in the list, so that one quantity does not fill it."""


def worst(tables: Sequence[RegionTable], most: int = 6) -> list[tuple[Region, bool]]:
    """Regions with most error over their share, and whether each is a single value."""
    found: list[tuple[Region, bool]] = []
    for table in tables:
        hot = [r for r in table.regions if r.share > NOTABLE * r.of_samples and r.share > 0.1]
        hot.sort(key=lambda r: r.of_samples - r.share)
        found += [(r, discrete(table.regions)) for r in hot[:PER_QUANTITY]]
    return sorted(found, key=lambda f: f[0].of_samples - f[0].share)[:most]
