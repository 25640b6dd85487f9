"""What the part that no model explains depends on, so that its effect can be written."""

from __future__ import annotations

import numpy as np

from er_model_lab.report.figure import Axis, Bars, Figure, Panel
from er_model_lab.report.palette import BEFORE
from er_model_lab.report.section import Section
from er_model_lab.report.units import newtons, percent, short
from er_model_lab.view import View


def section(view: View) -> Section | None:
    """Inputs the residual depends on, and a spectral line; None when nothing is left."""
    left = view.result.get("unexplained") or {}
    depends = {str(k): float(v) for k, v in (left.get("depends_on") or {}).items()}
    line = left.get("line") or {}
    hum = ""
    if line.get("share"):
        tone = f"a steady tone at {short(line['frequency'])} Hz of {newtons(line['amplitude'])}"
        hum = f"{tone}, {percent(line['share'])} of its power"
    if not depends and not hum:
        return None
    figures = (_figure(depends),) if depends else ()
    return Section(
        "unexplained", "The rest", figures, {"share": percent(left.get("share")), "hum": hum}
    )


def _figure(depends: dict[str, float]) -> Figure:
    """Loss of explained variance when one input is shuffled."""
    n = len(depends)
    at = np.arange(float(n))[::-1]
    values = np.array(list(depends.values()))
    ticks = tuple((float(a), name) for a, name in zip(at, depends, strict=True))
    text = tuple(percent(v) for v in values)
    bars = Bars(at, 100.0 * values, "", (BEFORE,) * n, text=text, horizontal=True, width=0.7)
    panel = Panel((bars,), Axis("loss of explained variance when shuffled [%]"), Axis(ticks=ticks))
    first = next(iter(depends))
    alt = f"Importance of the inputs for the rest of the residual; the first is {first}."
    return Figure("unexplained", alt, (panel,), height=110 + 30 * n)
