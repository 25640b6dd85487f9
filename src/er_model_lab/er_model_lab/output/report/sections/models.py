"""Several models side by side: their errors, and where each fails."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from er_model_lab.output.report.figure import Axis, Bars, Figure, Line, Mark, Panel, Points
from er_model_lab.output.report.palette import MODELS
from er_model_lab.output.report.section import Section
from er_model_lab.output.text.units import discrete, newtons, percent, shown, ticks
from er_model_lab.residual.region import RegionTable
from er_model_lab.view import View

SHOWN = ("velocity", "deflection", "duty", "frequency")
"""Quantities over which the models are compared."""
MINUS = "\N{MINUS SIGN}"


def section(view: View) -> Section | None:
    """Table and figures; None when one model stands alone."""
    entries = view.result.get("models") or []
    if len(entries) < 2:
        return None
    figures = [_errors(entries)]
    tables = {name: t for name, t in view.rival_regions if t}
    if len(tables) > 1:
        figures.append(_where(tables))
    records = list(entries[0]["rmse_by_record"])
    facts = {
        "rows": [_row(e, first=k == 0) for k, e in enumerate(entries)],
        "names": [e["model"] for e in entries],
        "records": [
            (r, [newtons(e["rmse_by_record"].get(r)) for e in entries]) for r in records[:25]
        ] if len(records) > 1 else [],
    }  # fmt: skip
    return Section("models", "The models", tuple(figures), facts)


def against(e: Mapping[str, Any]) -> str:
    """Change of the error against the first model, with its band."""
    low, high = e["against_first"]["band"]
    change = e["against_first"]["change"]
    return f"{_signed(change)} N ({_signed(low)} to {_signed(high)})"


def _signed(value: float) -> str:
    """A number with its sign."""
    return f"{value:+.3f}".replace("-", MINUS)


def _row(e: Mapping[str, Any], *, first: bool) -> dict[str, str]:
    """One line of the table."""
    return {
        "name": e["model"], "file": e["model_file"], "rmse": newtons(e["rmse"]), "nrmse": percent(e["nrmse"]),
        "share": percent(e["explainable"]), "against": "" if first else against(e),
        "seen": "fitted to these data" if e["fitted_to_these_data"] else "",
        "effects": ", ".join(e["effects"]),
    }  # fmt: skip


def _errors(entries: list[Mapping[str, Any]]) -> Figure:
    """A bar for the error of each model."""
    n = len(entries)
    size = np.array([float(e["rmse"]) for e in entries])
    at = np.arange(float(n))[::-1]
    bars = Bars(
        at, size, "", tuple(MODELS[k % len(MODELS)] for k in range(n)), text=tuple(newtons(s) for s in size),
        horizontal=True, width=0.66,
    )  # fmt: skip
    names = tuple((float(a), str(e["model"])) for a, e in zip(at, entries, strict=True))
    x = Axis("rms error [N]", (0.0, 1.15 * float(size.max())))
    words = ", ".join(f"{e['model']} {newtons(e['rmse'])}" for e in entries)
    panel = Panel((bars,), x, Axis(ticks=names, span=(-0.6, n - 0.4)))
    return Figure("models", f"Errors of the models: {words}.", (panel,), height=90 + 40 * n)


def _where(tables: Mapping[str, tuple[RegionTable, ...]]) -> Figure:
    """The error of each model per bin of each quantity, on the bins of the first."""
    first = next(iter(tables.values()))
    top = 1.08 * max(r.rms for own in tables.values() for t in own for r in t.regions)
    panels = []
    for k, t in enumerate([t for t in first if t.quantity in SHOWN]):
        marks: list[Mark] = []
        for m, (name, own) in enumerate(tables.items()):
            same = next((o for o in own if o.quantity == t.quantity), None)
            if same is None or len(same.regions) != len(t.regions):
                continue
            at = np.arange(float(len(t.regions)))
            rms = np.array([r.rms for r in same.regions])
            colour = MODELS[m % len(MODELS)]
            if not discrete(t.regions):
                marks.append(Line(at, rms, "", colour, 1.0))
            marks.append(Points(at, rms, name, colour, 6.0, 1.0))
        unit = f" [{shown(t.unit)}]" if shown(t.unit) else ""
        x = Axis(ticks=ticks(t.regions), span=(-0.6, len(t.regions) - 0.4))
        y = Axis("rms error [N]" if k % 2 == 0 else "", (0.0, top))
        panels.append(Panel(tuple(marks), x, y, t.quantity + unit))
    alt = f"Rms error of {', '.join(tables)} per bin of {', '.join(p.title for p in panels)}."
    return Figure("models_where", alt, tuple(panels), 2, height=235 * (-(-len(panels) // 2)) + 60)
