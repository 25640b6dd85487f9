"""Which plan to ask for after a diagnosis: what the data could not decide."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from er_model_lab.planning.question import KINEMATIC

MOST = 2

Suggestion = dict[str, Any]
"""Arguments of a plan: `between` two effects, or to `reveal` one."""


def suggestions(result: Mapping[str, Any]) -> list[Suggestion]:
    """Plans that would decide what the data could not: tied effects first, else one not excited."""
    groups = [[e for e in g if e != KINEMATIC] for g in result.get("alternatives") or ()]
    asked = [{"between": group[:2]} for group in groups if len(group) > 1]
    return (asked or _rival(result) or _hidden(result))[:MOST]


def _rival(result: Mapping[str, Any]) -> list[Suggestion]:
    """What was named on data that cannot be sure of it, and what explains them nearly as well."""
    named = [e for e in result.get("effects") or () if e != KINEMATIC]
    if result.get("verdict") != "ambiguous" or not named:
        return []
    others = [
        c for c in result.get("candidates") or ()
        if c["effect"] not in (*named, KINEMATIC) and c["evidence"] > c.get("threshold", math.inf)
    ]  # fmt: skip
    best = min(others, key=lambda c: float(c["rmse_cross_validated"]), default=None)
    return [{"between": [named[0], best["effect"]]}] if best else []


def _hidden(result: Mapping[str, Any]) -> list[Suggestion]:
    """The first effect that the data did not excite, and that a plan can be asked for."""
    found = [
        c["effect"]
        for c in result.get("candidates") or ()
        if c.get("status") == "not_excited" and c["effect"] != KINEMATIC
    ]
    return [{"reveal": found[0]}] if found else []
