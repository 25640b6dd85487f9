"""The page of `lab effects`: cards of the catalogue with their pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from er_models.card import card_text
from er_models.cards.picture import experiment, svg
from er_models.catalogue import Catalogue
from er_models.effect import Effect

from er_model_lab.output.report.embed import drawing
from er_model_lab.output.report.page import write_report
from er_model_lab.output.report.section import Section
from er_model_lab.view import View


def write_cards(
    effects: Sequence[Effect], catalogue: Catalogue, result: Mapping[str, Any], folder: Path
) -> Path:
    """The cards with their pictures as a page of its own; returns its file."""
    sections = [
        Section(
            e.name, e.title, template="effect_card",
            facts={
                "name": e.name, "text": card_text(e), "experiment": experiment(e),
                "picture": drawing(svg(e, catalogue).encode()),
            },
        )
        for e in effects
    ]  # fmt: skip
    name = effects[0].name if len(effects) == 1 else "catalogue"
    return write_report(View("effects", name, "", result, ()), folder, sections)
