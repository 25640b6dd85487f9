"""What the data cannot tell apart, and what to record so that they can."""

from __future__ import annotations

from er_model_lab.output.report.section import Section
from er_model_lab.output.text.verdict_text import joined, title_of
from er_model_lab.view import CandidateView, View


def section(view: View) -> Section | None:
    """Groups of effects that explain the data equally well; None when there are none."""
    cards = {card.effect: card for card in view.candidates}
    groups = []
    for group in view.result.get("alternatives") or ():
        known = [cards[e] for e in group if e in cards]
        groups.append({
            "names": joined([title_of(view, e) for e in group]), "cards": known,
            "records": _experiments(known),
            "effects": list(group),
        })  # fmt: skip
    hints = tuple((view.result.get("coverage") or {}).get("hints") or ())
    plans = list(view.result.get("next") or ())
    facts = {"groups": groups, "hints": hints, "plans": plans}
    return Section("alternatives", "Alternatives", facts=facts) if groups else None


def _experiments(cards: list[CandidateView]) -> list[tuple[str, list[str]]]:
    """Each experiment once, with the effects it would show."""
    found: dict[str, list[str]] = {}
    for card in cards:
        if card.experiment:
            found.setdefault(card.experiment, []).append(card.title)
    return list(found.items())
