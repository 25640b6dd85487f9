"""What is wrong with the data, and what they do not cover, on one screen."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rich.console import RenderableType

from er_model_lab.output.terminal.markup import Pen
from er_model_lab.output.text.findings import grouped, place_of
from er_model_lab.output.text.units import short
from er_model_lab.output.text.verdict_text import joined
from er_model_lab.view import View

MOST_FINDINGS = 12
MOST_CELLS = 9
TONES = {"fail": "bold red", "warning": "yellow", "note": "dim", "ok": "dim"}


def preflight_lines(view: View, pen: Pen) -> Iterator[RenderableType]:
    """All findings of `check`; of other commands, one line where there is something to say."""
    found = view.result.get("preflight")
    if not found:
        return
    if view.command != "check":
        yield from _short(found, pen)
        return
    yield from _findings(found, pen)
    yield from _cells(found, pen)


def _short(found: Mapping[str, Any], pen: Pen) -> Iterator[RenderableType]:
    """One line for the data: what was found worst."""
    bad = [f for f in found["findings"] if f["level"] in ("fail", "warning")]
    if not bad:
        return
    groups = grouped(bad)
    f, records = groups[0]
    more = f"; {len(groups) - 1} more (./er lab check)" if len(groups) > 1 else ""
    text = f"data: {f['check']} of {place_of(f, records)}: {f['found']}"
    yield pen.line(text + more, TONES[f["level"]])


def _findings(found: Mapping[str, Any], pen: Pen) -> Iterator[RenderableType]:
    """Each finding in a line, what to do about those that matter below it."""
    groups = grouped(found["findings"])
    yield pen.line("")
    for f, records in groups[:MOST_FINDINGS]:
        head = f"{f['level']:<8}{f['check']:<10}{place_of(f, records)}: {f['found']}"
        if f["level"] == "ok":
            yield pen.line(pen.cut(head, pen.width), TONES["ok"])
            continue
        yield pen.line(f"{head}; expected {f['expected']}", TONES[f["level"]])
    if len(groups) > MOST_FINDINGS:
        yield pen.line(f"{len(groups) - MOST_FINDINGS} more in the report", "dim")
    todo = dict.fromkeys(f["remedy"] for f, _ in groups if f["level"] in ("fail", "warning"))
    for remedy in list(todo)[:3]:
        yield pen.line(f"do: {remedy}")


def _cells(found: Mapping[str, Any], pen: Pen) -> Iterator[RenderableType]:
    """Regions the data lack, and the effects that stay hidden."""
    r = found["reach"]
    yield pen.line("")
    yield pen.line(
        f"reach ({r['known_from']}): {short(1e3 * r['deflection'])} mm, {short(1e3 * r['velocity'])} mm/s, "
        f"duty {short(r['duty'])}"
    )  # fmt: skip
    lacking = [c for c in found["cells"] if not c["covered"]]
    if not lacking:
        yield pen.line("every region that an effect needs is covered")
        return
    without = [c for c in lacking if "duty" in c["name"]] if not r["duty"] else []
    told = [c for c in lacking if c not in without]
    rows = [
        [
            pen.safe(c["name"].replace("_", " ")), f"{short(c['have'], 2)} of {short(c['need'], 2)} {c['unit']}",
            pen.safe(joined(c["effects"]).replace("_", " ")),
        ]
        for c in told[:MOST_CELLS]
    ]  # fmt: skip
    if without:
        others = {e for c in found["cells"] if c not in without for e in c["effects"]}
        own = dict.fromkeys(e for c in without for e in c["effects"] if e not in others)
        rows.insert(0, ["duty", "none", pen.safe(joined(list(own)).replace("_", " "))])
    yield pen.table([("missing", ""), ("have", "right"), ("so these may stay hidden", "")], rows)
