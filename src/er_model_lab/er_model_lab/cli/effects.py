"""`lab effects`: the catalogue as a table, and one effect's card."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from er_models.card import card_text
from er_models.catalogue import Catalogue
from er_models.effect import Effect
from rich.console import RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text


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


def shown(catalogue: Catalogue, level: str) -> list[Effect]:
    """Effects that act at a level: of the damper alone, or of the whole car."""
    return [e for e in catalogue.effects if level == "vehicle" or e.stage != "vehicle"]


def table(effects: Sequence[Effect]) -> tuple[dict[str, Any], RenderableType]:
    """Effects: plain data and a table; those that cannot be known say why."""
    out = Table(title="effects", show_lines=False)
    for column in ("effect", "stage", "what it is", "shows itself as"):
        out.add_column(column, overflow="fold")
    for effect in effects:
        mark = effect.signature.mark if effect.knowable else because(effect)
        out.add_row(effect.name, effect.stage, effect.title, escape(mark))
    return {"effects": [_data(e) for e in effects]}, out


def card(name: str, catalogue: Catalogue) -> tuple[dict[str, Any], RenderableType]:
    """One effect: plain data and its card; `UnknownName` if there is none."""
    effect = catalogue[name]
    return _data(effect), Text(card_text(effect))


def because(effect: Effect) -> str:
    """Why an effect cannot be known."""
    return f"cannot be known from these channels, because {effect.unknowable_because}"
