"""Evidence card of each candidate: physics, equation, numbers, signature, and the reason."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from er_model_lab.output.report.figure import Axis, Figure, Line, Panel, Points
from er_model_lab.output.report.palette import AFTER, INK, RESIDUAL, STATUS
from er_model_lab.output.report.samples import binned_mean
from er_model_lab.output.report.section import Section
from er_model_lab.output.text.ranking import beside, effect_size
from er_model_lab.output.text.units import arrow, gain, newtons, parameter, percent, short
from er_model_lab.output.text.verdict_text import (
    joined,
    rmse,
    standing,
    standing_words,
    title_of,
)
from er_model_lab.view import CandidateView, View

PLANES: dict[str, tuple[str, float]] = {
    "force-velocity": ("velocity [mm/s]", 1e3),
    "force-deflection": ("deflection [mm]", 1e3),
    "force-acceleration": ("acceleration [m/s2]", 1.0),
    "force-duty": ("duty", 1.0),
    "time": ("time [s]", 1.0),
}
"""Axis label and factor from SI by the plane in which a signature shows."""
OPEN = 3
"""Cards open at once beside those of effects that were taken."""


def section(view: View) -> Section | None:
    """One card per candidate, best first; None without candidates."""
    if not view.candidates:
        return None
    cards = [_card(view, card, k) for k, card in enumerate(view.candidates)]
    figures = tuple(card["figure"] for card in cards if card["figure"] is not None)
    return Section("cards", "Evidence", figures, {"cards": cards})


def _card(view: View, card: CandidateView, k: int) -> dict[str, Any]:
    """What one card shows."""
    e = card.entry
    status = str(e.get("status", ""))
    return {
        "effect": card.effect, "title": card.title, "physics": card.physics,
        "equations": card.equations,
        "mark": card.mark, "experiment": card.experiment, "reason": card.reason,
        "status": standing_words(view, e), "colour": STATUS.get(standing(e), INK),
        "open": k < OPEN or status in ("present", "confounded"), "numbers": [*_numbers(view, e), *_taken(card)],
        "parameters": [(name, parameter(v)) for name, v in (e.get("parameters") or {}).items()],
        "confounded": joined([title_of(view, o) for o in e.get("confounded_with") or ()], "or"),
        "figure": _figure(card) if card.signature_x.size > 1 else None,
    }  # fmt: skip


def _numbers(view: View, e: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Names and values of the evidence."""
    before = e.get("rmse_before", rmse(view.result))
    size = effect_size(view, e)
    rows = [
        (
            "error on held-out data, without and with it",
            arrow(before, e.get("rmse_held_out")),
        )
    ]
    if "basis" in e:
        rows.append(("basis", str(e["basis"])))
    elif size is not None:
        chance = (
            f", chance reaches {newtons(e['threshold'])}" if e.get("threshold") is not None else ""
        )
        rows.append(("effect size, training data", gain(size, beside(view, e)) + chance))
    if e.get("explains") is not None:
        rows.append(
            ("explains, training data", f"{percent(e['explains'])} of what can be explained")
        )
    if e.get("p_value") is not None:
        rows.append(("p value", short(e["p_value"], 2)))
    if e.get("kept_fraction") is not None:
        rows.append(("not absorbed by the model", percent(e["kept_fraction"])))
    return rows


def _taken(card: CandidateView) -> list[tuple[str, str]]:
    """What of the residual the effect takes: share of its mean square, on the samples shown."""
    left, after = card.residual_y, card.residual_y - card.signature_y
    power = float(np.mean(left**2)) if left.size else 0.0
    if power <= 0.0:
        return []
    return [
        (
            "takes of the residual, training data",
            percent(max(1.0 - float(np.mean(after**2)) / power, 0.0)),
        )
    ]


def _figure(card: CandidateView) -> Figure:
    """The force the effect adds, over what the model left, in the plane where it shows."""
    label, factor = PLANES.get(card.plane, ("velocity [mm/s]", 1e3))
    x = card.signature_x * factor
    marks = (
        Points(x, card.residual_y, "left by the model", RESIDUAL, 3.4, 0.6),
        Points(x, card.signature_y, "explained by the effect", AFTER, 3.0, 0.45),
        Line(*binned_mean(x, card.residual_y), "", INK, 1.6),
        Line(*binned_mean(x, card.signature_y), "", AFTER, 1.6),
    )
    spread = float(np.std(card.signature_y))
    alt = (
        f"{card.title}: what the model left, and the part of it this effect explains "
        f"(rms {newtons(spread)}), in the plane {card.plane}."
    )
    panel = Panel(marks, Axis(label), Axis("force [N]"))
    return Figure(
        f"signature_{card.effect}", alt, (panel,), height=270, width=430, interactive=False
    )
