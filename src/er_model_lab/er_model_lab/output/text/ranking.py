"""The candidates of a result in the order in which they help, and the size each reaches."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from er_model_lab.output.text.units import newtons
from er_model_lab.view import View

LESS = 0.9
"""Share of what chance reaches at first below which what it reaches later is said, too."""
Entry = Mapping[str, Any]


def effect_size(view: View, entry: Entry) -> float | None:
    """Fall of the error [N]: as the result states it, else from the errors on held-out data.

    Sizes are roots of the fall of the mean square, negative where the error rises.
    """
    stated = entry.get("evidence")
    if isinstance(stated, int | float):
        return float(stated)
    before, after = view.result.get("rmse"), entry.get("rmse_held_out")
    start = before.get("held_out") if isinstance(before, Mapping) else before
    if start is None or after is None:
        return None
    fall = float(start) ** 2 - float(after) ** 2
    return math.copysign(math.sqrt(abs(fall)), fall)


def largest(view: View) -> float:
    """Largest effect size of all candidates [N]; sizes of another kind, which state their basis, aside."""
    entries = [e for e in view.result.get("candidates") or () if "basis" not in e]
    return max([effect_size(view, e) or 0.0 for e in entries], default=0.0)


def beside(view: View, entry: Entry) -> float:
    """Size [N] beside which that of a candidate is told: none for what was taken, as it counts however small it is."""
    return 0.0 if entry["effect"] in (view.result.get("effects") or ()) else largest(view)


def ranked(view: View) -> list[Entry]:
    """What the result takes first, then the others by effect size."""
    taken = list(view.result.get("effects") or ())
    entries: list[Entry] = list(view.result.get("candidates") or ())

    def order(e: Entry) -> tuple[int, float]:
        place = taken.index(e["effect"]) if e["effect"] in taken else len(taken)
        return place, -(effect_size(view, e) or 0.0)

    return sorted(entries, key=order)


def limit(view: View) -> float | None:
    """Effect size that chance reaches in the first round [N], when the result states it: what none took is of that."""
    stated = [e["threshold"] for e in ranked(view) if e.get("threshold") is not None]
    return float(stated[-1]) if stated else None


def chance_says(view: View) -> str:
    """What effect size chance reaches, in a sentence; less, where what was found left less to be explained."""
    first = limit(view)
    if first is None:
        return ""
    least = min(float(e["threshold"]) for e in ranked(view) if e.get("threshold") is not None)
    later = f" at first, {newtons(least)} beside what was found" if least < LESS * first else ""
    return f"chance alone reaches a size of {newtons(first)}{later}"
