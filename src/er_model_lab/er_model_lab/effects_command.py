"""`lab effects`: the catalogue as a table, and one effect's card."""

from __future__ import annotations

from typing import Any

from er_models.card import card_text
from er_models.catalogue import CATALOGUE
from er_models.effect import Effect
from rich.console import RenderableType
from rich.table import Table


def _data(effect: Effect) -> dict[str, Any]:
    """An effect as plain data."""
    return {
        "effect": effect.name,
        "stage": effect.stage,
        "title": effect.title,
        "physics": effect.physics,
        "knowable": effect.knowable,
        "unknowable_because": effect.unknowable_because,
        "parameters": [
            {"name": q.name, "unit": q.unit, "neutral": _finite(q.neutral), "meaning": q.meaning}
            for q in effect.parameters
        ],
        "mark": effect.signature.mark,
        "experiment": effect.signature.experiment,
        "rivals": list(effect.signature.rivals),
        "source": effect.source,
    }


def _finite(value: float | None) -> float | str | None:
    """Numbers that JSON can hold."""
    return "inf" if value == float("inf") else value


def table() -> tuple[dict[str, Any], RenderableType]:
    """All effects: plain data and a table."""
    out = Table(title="effects", show_lines=False)
    for column in ("effect", "stage", "what it is", "shows itself as"):
        out.add_column(column, overflow="fold")
    for effect in CATALOGUE.effects:
        out.add_row(effect.name, effect.stage, effect.title, effect.signature.mark)
    return {"effects": [_data(e) for e in CATALOGUE.effects]}, out


def card(name: str) -> tuple[dict[str, Any], RenderableType]:
    """One effect: plain data and its card; `UnknownName` if there is none."""
    effect = CATALOGUE[name]
    return _data(effect), card_text(effect)
