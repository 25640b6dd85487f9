"""Every candidate ranked by what it takes off the error, against what chance reaches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from er_model_lab.output.report.figure import Axis, Bars, Figure, Level, Mark, Panel
from er_model_lab.output.report.palette import INK, STATUS
from er_model_lab.output.report.section import Section
from er_model_lab.output.text.ranking import beside, effect_size, largest, limit, ranked
from er_model_lab.output.text.units import gain, newtons, parameter, percent, short
from er_model_lab.output.text.verdict_text import STATUS as SAID
from er_model_lab.output.text.verdict_text import (
    standing,
    standing_words,
    title_of,
    unknowable,
)
from er_model_lab.view import Array, View

MOST_BARS = 14
FIRST_ROWS = 8
"""Rows of the table that are open at once."""


def section(view: View) -> Section | None:
    """Bars of the effect size, and the numbers as a table; None without candidates."""
    entries = ranked(view)
    if not entries:
        return None
    sized = [e for e in entries if effect_size(view, e) is not None and "basis" not in e][
        :MOST_BARS
    ]
    figures = (_figure(view, sized),) if sized else ()
    rows = [_row(view, e) for e in entries]
    return Section(
        "candidates",
        "Candidates",
        figures,
        {"first": rows[:FIRST_ROWS], "others": rows[FIRST_ROWS:], "unknowable": unknowable(view)},
    )


def _row(view: View, e: Mapping[str, Any]) -> dict[str, Any]:
    """One line of the table."""
    size = effect_size(view, e)
    return {
        "effect": e["effect"], "title": title_of(view, str(e["effect"])),
        "rmse": newtons(e.get("rmse_held_out")),
        "size": gain(None if "basis" in e else size, beside(view, e)),
        "explains": percent(e.get("explains")),
        "p": short(e.get("p_value"), 2), "status": standing_words(view, e),
        "colour": STATUS.get(standing(e), INK),
        "parameters": [f"{k} = {parameter(v)}" for k, v in (e.get("parameters") or {}).items()],
        "has_card": any(card.effect == e["effect"] for card in view.candidates),
        "basis": e.get("basis", ""),
    }  # fmt: skip


def _figure(view: View, entries: Sequence[Mapping[str, Any]]) -> Figure:
    """Horizontal bars, best on top, coloured and named by status."""
    sizes = np.array([effect_size(view, e) or 0.0 for e in entries])
    at = np.arange(float(len(entries)))[::-1]
    marks = _bars(view, entries, at, sizes)
    chance = limit(view)
    if chance is not None:
        marks.append(Level(chance, f"chance reaches {newtons(chance)}", INK, vertical=True))
    names = [title_of(view, str(e["effect"])) for e in entries]
    ticks = tuple((float(a), name) for a, name in zip(at, names, strict=True))
    span = (0.0, 1.15 * max(float(sizes.max()), chance or 0.0, 1e-6))
    x = Axis("effect size: fall of the error on data left out [N]", span)
    panel = Panel(tuple(marks), x, Axis(ticks=ticks, span=(-0.6, len(entries) - 0.4)))
    most = newtons(float(sizes[0]))
    alt = f"Effect size of {len(entries)} candidates; the first is {names[0]} with {most}."
    return Figure("candidates", alt, (panel,), height=130 + 27 * len(entries))


def _bars(view: View, entries: Sequence[Mapping[str, Any]], at: Array, sizes: Array) -> list[Mark]:
    """One set of bars per status, so that the legend names each colour."""
    status = np.array([standing(e) for e in entries])
    bars: list[Mark] = []
    for key in dict.fromkeys(status.tolist()):
        rows = status == key
        text = tuple(gain(s, largest(view)) for s in sizes[rows])
        colours = (STATUS.get(key, INK),) * int(rows.sum())
        size = np.maximum(sizes[rows], 0.0)
        name = SAID.get(key, key)
        bars.append(Bars(at[rows], size, name, colours, text=text, horizontal=True, width=0.7))
    return bars
