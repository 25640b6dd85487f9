"""What was learnt beside the effects: a term over its quantities, what it looks like, and a file to begin from."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from er_models.measured import LABEL, LAGGED, QUANTITIES

from er_model_lab.output.report.figure import Axis, Figure, Line, Panel, Scale, Tiles
from er_model_lab.output.report.palette import BEFORE, SIGNED
from er_model_lab.output.report.section import Section
from er_model_lab.output.text.units import factor, labelled, newtons, percent
from er_model_lab.output.text.verdict_text import title_of
from er_model_lab.view import View


def section(view: View) -> Section | None:
    """Picture and facts of the first measured term; None where none was learnt."""
    terms = view.result.get("measured_terms") or ()
    if not terms:
        return None
    term = terms[0]
    held = term["rmse_held_out"]
    facts = {
        "name": term["name"], "label": LABEL, "shape": ", ".join(term["shape"]),
        "before": newtons(held["before"]), "after": newtons(held["after"]),
        "near": [(title_of(view, e["effect"]), percent(e["share"])) for e in term["looks_like"]],
        "formula": (term["formula"] or {}).get("text", ""),
        "share": percent((term["formula"] or {}).get("share")),
        "of_term": percent((term["formula"] or {}).get("share_of_term")),
        "source": term["effect_source"] or "",
    }  # fmt: skip
    return Section("measured_terms", f"What was learnt: {LABEL}", (_figure(term),), facts)


def _figure(term: Mapping[str, Any]) -> Figure:
    """The term over its quantities, where samples lie."""
    unit = f"N per {term['times'].replace('_', ' ')}" if term["times"] else "N"
    names, drawn = term["quantities"], term["drawn"]
    force = np.array(drawn["force"], np.float64)
    units = [QUANTITIES[q.removesuffix(LAGGED)][1] for q in names]
    edges = [np.asarray(drawn["edges"][q]) * factor(u) for q, u in zip(names, units, strict=True)]
    labels = [Axis(labelled(q.replace("_", " "), u)) for q, u in zip(names, units, strict=True)]
    alt = f"The term {term['name']} over {' and '.join(names)}."
    if len(names) == 1:
        line = Line(0.5 * (edges[0][1:] + edges[0][:-1]), force, "term", BEFORE, 1.6)
        return Figure("measured_terms", alt, (Panel((line,), labels[0], Axis(f"term [{unit}]")),))
    peak = max(float(np.nanmax(np.abs(force))), 1e-12)
    scale = Scale(f"term [{unit}]", -peak, peak, SIGNED)
    panel = Panel((Tiles(edges[0], edges[1], force.T),), labels[0], labels[1])
    return Figure("measured_terms", alt, (panel,), scale=scale)
