"""What a page shows of a fleet: rows of its units, and the series that change."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from er_model_lab.view import FleetView, SeriesView

MOST_ROWS, MOST_SERIES = 5000, 6
"""Units whose rows travel in a page, and series that are drawn, at most."""


def fleet_view(
    rows: Iterable[Mapping[str, Any]], told: Mapping[str, Mapping[str, Any]], differ: Sequence[Mapping[str, Any]],
    parts: Callable[[str], Iterable[Mapping[str, Any]]], pages: Mapping[str, str],
) -> FleetView:  # fmt: skip
    """The view: told: what each unit's row gets; parts: the recordings of a unit."""
    order = sorted(told, key=lambda u: float(told[u]["p"]))[:MOST_ROWS]
    known = {str(r["unit"]): r for r in rows if r["unit"] in set(order)}
    changing = [(d["unit"], c) for d in differ for c in d["changes"][:1]][:MOST_SERIES]
    return FleetView(
        tuple({**known[u], **told[u]} for u in order), len(told),
        tuple(_series(unit, change, parts(unit)) for unit, change in changing), pages,
    )  # fmt: skip


def _series(
    unit: str, change: Mapping[str, Any], parts: Iterable[Mapping[str, Any]]
) -> SeriesView:
    """The values of a unit's recordings that change."""
    quantity, axis = change["quantity"], change["axis"]
    numbered = ({"recordings": n, **part} for n, part in enumerate(parts, 1))
    found = [(p[axis], *value_in(quantity, p)) for p in numbered if p.get(axis) is not None]
    x, y, s = np.array([f for f in found if f[2] is not None], float).reshape(-1, 3).T
    return SeriesView(unit, quantity, axis, x, y, s, change)


def value_in(quantity: str, part: Mapping[str, Any]) -> tuple[float | None, float | None]:
    """Value and deviation of a quantity in one recording."""
    if quantity in (part.get("values") or {}):
        value, sd, _ = part["values"][quantity]
        return value, sd
    left = part.get("rmse_refitted")
    return (
        (None, None)
        if not left
        else (float(np.log(left)), (2.0 * float(part["independent"])) ** -0.5)
    )
