"""A planned experiment on one screen."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rich.console import RenderableType

from er_model_lab.output.report.sections.programs import head, row
from er_model_lab.output.terminal.markup import Pen
from er_model_lab.view import View

MOST_PROGRAMS = 4


def plan_lines(view: View, pen: Pen) -> Iterator[RenderableType]:
    """Table of programs, why the first one, and where it was written."""
    if "programs" not in view.result:
        return
    result = view.result
    rows = [*result["programs"][:MOST_PROGRAMS], *filter(None, [result["identification"]])]
    if rows:
        columns = [(name, "right" if k else "") for k, name in enumerate(head(result))]
        yield pen.line("")
        yield pen.table(columns, [[pen.safe(c) for c in row(result, r)] for r in rows])
        yield pen.line("separation over the noise, by what is true; then peaks", "dim")
    yield pen.line("")
    for sentence in result["why"][1:]:
        yield pen.line(sentence)
    for name in result["strengths"]:
        yield pen.line(_strength(name, result["strengths"][name]), "dim")
    if result.get("program_file"):
        yield pen.line(f"program: {result['program_file']}")


def _strength(name: str, entry: Mapping[str, Any]) -> str:
    """How strong an effect was taken to be."""
    values = ", ".join(f"{p} {v[0]:.3g} {v[2]}" for p, v in entry["parameters"].items())
    return f"{name} {entry['source']}: {values}"
