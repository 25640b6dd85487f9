"""A fleet on one screen: how many units, what they share, which differ and in what."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rich.console import RenderableType

from er_model_lab.output.terminal.markup import Pen
from er_model_lab.output.text.fleet import change, suggested
from er_model_lab.output.text.units import parameter, percent, quantity, short
from er_model_lab.view import View

MOST_UNITS, MOST_NEXT, MOST_PARAMETERS, MOST_FAILED = 10, 3, 8, 3


def fleet_lines(view: View, pen: Pen) -> Iterator[RenderableType]:
    """Verdicts, effects, units that differ, parameters, what to record next, and the tables."""
    found = view.result
    yield pen.line(pen.cut(f"fleet {view.model}: {view.headline}", pen.width), "bold")
    yield pen.line(pen.cut("verdicts: " + _counted(found["verdicts"]), pen.width))
    yield pen.line(pen.cut("recordings: " + _counted(found["statuses"]), pen.width))
    if found["effects"]:
        said = ", ".join(
            f"{e['effect']} {e['units']} ({percent(e['share'])})" for e in found["effects"][:6]
        )
        yield pen.line(pen.cut(f"effects: {said}", 2 * pen.width - 20))
    yield from _differ(found, pen)
    yield from _parameters(found, pen)
    for each in found["failed"][:MOST_FAILED]:
        yield pen.line(
            pen.cut(f"{each['status']}: {each['path']}: {each['error']}", 2 * pen.width - 20),
            "yellow",
        )
    for each in found["record_next"][:MOST_NEXT]:
        yield pen.line(pen.cut(f"record next: {each['unit']}: {suggested(each)}", pen.width))
    for what, path in found["tables"].items():
        yield from map(pen.whole, [f"{what}: {path}"])


def _counted(found: Mapping[str, int]) -> str:
    """Numbers of things by name."""
    return ", ".join(f"{name} {n}" for name, n in found.items()) or "none"


def _differ(found: Mapping[str, Any], pen: Pen) -> Iterator[RenderableType]:
    """The strangest units."""
    if not found["differ"]:
        return
    rows = [
        [
            pen.cut(each["unit"], 24), pen.safe(short(each["p"], 2)),
            pen.cut(pen.safe("; ".join([*_still(each), *map(change, each["changes"][:2])])), pen.width - 36),
        ]
        for each in found["differ"][:MOST_UNITS]
    ]  # fmt: skip
    yield pen.line("")
    yield pen.table([("differs", ""), ("p", "right"), ("in", "")], rows)
    if (more := len(found["differ"]) - len(rows)) > 0:
        yield pen.line(f"{more} more in the table", "dim")


def _still(each: Mapping[str, Any]) -> list[str]:
    """What differs without a change."""
    return [what for what in each["in"] if " over " not in what][:3]


def _parameters(found: Mapping[str, Any], pen: Pen) -> Iterator[RenderableType]:
    """What the units have in common."""
    rows = [
        [
            name, pen.safe(parameter([p["mean"], p["sd"], p["unit"]])),
            *(pen.safe(quantity(p[k], p["unit"])) for k in ("between", "within")),
        ]
        for name, p in list(found["parameters"].items())[:MOST_PARAMETERS]
    ]  # fmt: skip
    if rows:
        yield pen.line("")
        yield pen.table(
            [
                ("parameter", ""),
                ("common", "right"),
                ("between units", "right"),
                ("within", "right"),
            ],
            rows,
        )
