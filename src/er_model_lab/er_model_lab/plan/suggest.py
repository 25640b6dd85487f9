"""Which plan to ask for after a diagnosis: the command line, ready to be pasted."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from er_model_lab.plan.question import KINEMATIC

MOST = 2


def suggestions(
    result: Mapping[str, Any],
    model_file: Path,
    data: Sequence[Path],
    effects_from: Sequence[Path] = (),
    *,
    anyway: bool = False,
) -> list[str]:
    """Commands that plan what the data could not decide: tied effects first, else one not excited.

    anyway: the data are used although they fail the preflight.
    """
    words = ["./er", "lab", "plan", "--model", str(model_file)]
    words += [w for f in data for w in ("--data", str(f))]
    words += [w for f in effects_from for w in ("--effects-from", str(f))]
    words += ["--anyway"] * anyway
    groups = [[e for e in g if e != KINEMATIC] for g in result.get("alternatives") or ()]
    asked = [["--between", *group[:2]] for group in groups if len(group) > 1]
    if not asked:
        asked = _rival(result) or _hidden(result)
    return [shlex.join([*words, *a, "--out", "next.yaml"]) for a in asked[:MOST]]


def _rival(result: Mapping[str, Any]) -> list[list[str]]:
    """What was named on data that cannot be sure of it, and what explains them nearly as well."""
    named = [e for e in result.get("effects") or () if e != KINEMATIC]
    if result.get("verdict") != "ambiguous" or not named:
        return []
    others = [
        c for c in result.get("candidates") or ()
        if c["effect"] not in (*named, KINEMATIC) and c["evidence"] > c.get("threshold", math.inf)
    ]  # fmt: skip
    best = min(others, key=lambda c: float(c["rmse_cross_validated"]), default=None)
    return [["--between", named[0], best["effect"]]] if best else []


def _hidden(result: Mapping[str, Any]) -> list[list[str]]:
    """The first effect that the data did not excite, and that a plan can be asked for."""
    found = [
        c["effect"]
        for c in result.get("candidates") or ()
        if c.get("status") == "not_excited" and c["effect"] != KINEMATIC
    ]
    return [["--reveal", found[0]]] if found else []
