"""Duty programs one after another, again and again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from er_models.sequence import parts_of, run
from er_models.spec import Array, Kind


def kind(kinds: Mapping[str, Kind]) -> Kind:
    """The kind `sequence` over other kinds of duty program."""
    parts = parts_of(kinds)

    def make(s: Mapping[str, Any], t: Array, seed: int) -> Array:
        """Duty [1], (n,)."""
        return run(s["parts"], parts, "duty", t, seed)[0]

    return Kind("sequence", "duty programs one after another, again and again", (parts,), make)
