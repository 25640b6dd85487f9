"""Which regions of the data carry more of the error than their share, and when."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from er_model_lab.output.text.units import discrete
from er_model_lab.residual.region import Region, RegionTable
from er_model_lab.view import RecordView

NOTABLE = 1.3
"""Error over samples from which a region stands out."""
PER_QUANTITY = 2
"""Regions of one quantity in the list, so that one quantity does not fill it."""
ALWAYS = ("velocity", "deflection", "duty")
"""Quantities whose worst region is always told."""
STRETCH = re.compile(r"(.*)@(\d+)s$")
"""Name of a stretch of a long record: that of the record, and the second at which it begins."""


@dataclass(frozen=True)
class Failure:
    """A region where a model fails, whether it is a single value, and the record and second of most of its error."""

    region: Region
    single: bool
    when: tuple[str, float] | None = None


def worst(tables: Sequence[RegionTable], most: int = 6) -> list[tuple[Region, bool]]:
    """Regions with most error over their share, and whether each is a single value."""
    found: list[tuple[Region, bool]] = []
    for table in tables:
        hot = [r for r in table.regions if r.share > NOTABLE * r.of_samples and r.share > 0.1]
        hot.sort(key=lambda r: r.of_samples - r.share)
        found += [(r, discrete(table.regions)) for r in hot[:PER_QUANTITY]]
    return sorted(found, key=lambda f: f[0].of_samples - f[0].share)[:most]


def failures(
    tables: Sequence[RegionTable], records: Sequence[RecordView], *, after: bool, most: int = 6
) -> list[Failure]:
    """The worst region of velocity, deflection and duty, then others that stand out, `most` in all.

    records: where a second is looked for; after: of the model with what was added.
    """
    known = {t.quantity: t for t in tables if t.regions}
    first = [
        (max(t.regions, key=lambda r: r.share - r.of_samples), discrete(t.regions))
        for t in (known[name] for name in ALWAYS if name in known)
    ]
    others = [f for f in worst(tables, most) if f not in first]
    return [
        Failure(region, single, second_of(region, records, single=single, after=after))
        for region, single in (first + others)[:most]
    ]


def second_of(
    region: Region, records: Sequence[RecordView], *, single: bool, after: bool
) -> tuple[str, float] | None:
    """Record, and time [s] at which the second with most of the error in a region begins; None where none is known."""
    found: list[tuple[float, str, float]] = []
    for r in records:
        model = r.after if after else r.before
        values = {"velocity": r.velocity, "deflection": r.deflection, "duty": r.duty}.get(
            region.quantity
        )
        if model is None or values is None:
            continue
        low, high = region.edges
        within = np.isclose(values, low) if single else (values >= low) & (values <= high)
        inside = r.scored & within
        if inside.any():
            power = np.bincount(r.t[inside].astype(int), (r.measured - model)[inside] ** 2)
            part = STRETCH.match(r.name)
            name, since = (part[1], float(part[2])) if part else (r.name, 0.0)
            found.append((float(power.max()), name, since + float(power.argmax())))
    return max(found)[1:] if found else None
