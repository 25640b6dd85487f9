"""Parameters before and after on one screen."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rich.console import RenderableType

from er_model_lab.output.report.sections.identified import rows
from er_model_lab.output.terminal.markup import Pen
from er_model_lab.view import View

MOST_REASONS, WIDE = 6, 96
"""Findings that are listed, and the width from which on a status has a column of its own."""
USUAL = ("identified", "new")


def parameter_lines(view: View, pen: Pen) -> Iterator[RenderableType]:
    """Table of parameters; of an identification response times, too, and what to know before trusting them."""
    if not view.result.get("parameters"):
        return
    identified, wide = "stages" in view.result, pen.width >= WIDE
    found = [r for r in rows(view.result) if not (identified and r["status"].startswith("given"))]
    head = [
        ("parameter", ""),
        ("of", ""),
        ("before", "right"),
        ("after", "left"),
        ("bounds", "right"),
    ]
    more = ([("status", "")] if wide else []) + ([("10 % change", "right")] if identified else [])
    shown = [
        [
            r["name"], r["effect"], r["before"].partition(" ")[0], r["value"] if wide else _with_status(r), r["bounds"],
            *([r["status"]] if wide else []), *([r["visible"]] if identified else []),
        ]
        for r in found
    ]  # fmt: skip
    yield pen.line("")
    yield pen.table([*head, *more], [[pen.safe(cell) for cell in row] for row in shown])
    if identified:
        yield from _trust(view, pen)


def _with_status(r: Mapping[str, str]) -> str:
    """A value, with its status where that is not the usual one."""
    return r["value"] if r["status"] in USUAL else f"{r['value']} ({r['status']})"


def _trust(view: View, pen: Pen) -> Iterator[RenderableType]:
    """Response times, and what to know before trusting the values."""
    response = view.result.get("response_time")
    if response:
        said = ", ".join(
            f"{1e3 * level['tau']:.1f} at {level['duty']:.3g}" for level in response["levels"]
        )
        yield pen.line(f"response time [ms] at duty: {said}")
    reasons = list(view.result["reasons"])
    for reason in reasons[:MOST_REASONS]:
        yield pen.line(f"- {reason}", "yellow")
    if len(reasons) > MOST_REASONS:
        yield pen.line(f"{len(reasons) - MOST_REASONS} more findings in the JSON", "dim")
