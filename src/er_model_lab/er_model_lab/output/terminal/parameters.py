"""Identified parameters on one screen."""

from __future__ import annotations

from collections.abc import Iterator

from rich.console import RenderableType

from er_model_lab.output.report.sections.identified import SAID, entries, value_of
from er_model_lab.output.terminal.markup import Pen
from er_model_lab.output.text.units import newtons, short
from er_model_lab.view import View

MOST_REASONS = 6


def parameter_lines(view: View, pen: Pen) -> Iterator[RenderableType]:
    """Table of parameters, response times, and what to know before trusting them."""
    if "stages" not in view.result:
        return
    rows = [
        [
            f"{name}", effect.replace("_", " "), pen.safe(value_of(entry)), pen.safe(short(entry["before"], 4)),
            SAID[entry["status"]][0], pen.safe(newtons(entry.get("visible"))) if "visible" in entry else "",
        ]
        for effect, name, entry in entries(view.result)
        if entry["status"] != "given"
    ]  # fmt: skip
    columns = [
        ("parameter", ""), ("of", ""), ("value", ""), ("before", "right"), ("status", ""), ("10 % change", "right"),
    ]  # fmt: skip
    yield pen.line("")
    yield pen.table(columns, rows)
    response = view.result.get("response_time")
    if response:
        said = ", ".join(
            f"{1e3 * level['tau']:.1f} at {level['duty']:.3g}" for level in response["levels"]
        )
        yield pen.line(pen.cut(f"response time [ms] at duty: {said}", pen.width))
    reasons = list(view.result["reasons"])
    for reason in reasons[:MOST_REASONS]:
        yield pen.line(f"- {reason}", "yellow")
    if len(reasons) > MOST_REASONS:
        yield pen.line(f"{len(reasons) - MOST_REASONS} more findings in the JSON", "dim")
