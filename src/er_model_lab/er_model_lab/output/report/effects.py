"""The page of `lab effects`: cards of the catalogue with their pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from er_models.card import SCALED, STAGES, rows, terms
from er_models.cards.equation import equations
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
        Section(e.name, e.title, template="effect_card", facts=_facts(e, catalogue))
        for e in effects
    ]
    name = effects[0].name if len(effects) == 1 else "catalogue"
    return write_report(View("effects", name, "", result, ()), folder, sections)


def _facts(e: Effect, catalogue: Catalogue) -> dict[str, Any]:
    """What a card shows: what the card in the terminal holds, typeset."""
    s = e.signature
    return {
        "name": e.name, "stage": STAGES[e.stage].lower(), "physics": e.physics,
        "equations": equations(e), "terms": terms(e),
        "unknowable": "" if e.knowable else e.unknowable_because, "rows": rows(e), "scaled": SCALED,
        "experiment": experiment(e), "picture": drawing(svg(e, catalogue).encode()),
        "signature": [
            ("shows as", f"{s.mark} ({s.plane})"), ("shown best by", s.experiment),
            ("rivals", ", ".join(s.rivals) or "none"), ("source", e.source),
        ],
    }  # fmt: skip
