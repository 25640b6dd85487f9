"""One screen of summary for a terminal, and the same as plain ASCII for a file or a pipe."""

from __future__ import annotations

import shlex
import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console, ConsoleOptions, Group, RenderableType, RenderResult
from rich.constrain import Constrain
from rich.text import Text

from er_model_lab.output.report.sections.history import change, fall
from er_model_lab.output.report.sections.models import against
from er_model_lab.output.terminal.fleet import fleet_lines
from er_model_lab.output.terminal.markup import BLOCK, PLUS_MINUS, Pen
from er_model_lab.output.terminal.parameters import parameter_lines
from er_model_lab.output.terminal.plan import plan_lines
from er_model_lab.output.terminal.preflight import preflight_lines
from er_model_lab.output.text.ranking import effect_size, largest, limit, ranked
from er_model_lab.output.text.regions import worst
from er_model_lab.output.text.units import gain, newtons, parameter, percent, short, where
from er_model_lab.output.text.verdict_text import (
    joined,
    learnt,
    title_of,
    verdict_sentence,
    verdict_title,
)
from er_model_lab.view import View

WIDTH = 100
MOST_CANDIDATES = 6
MOST_STEPS = 5
MOST_NOTES, MOST_NOTES_INCOMPLETE = 1, 4
MOST_MODELS = 10
LEAST_ROOM = 18
"""Columns below which the table goes without parameters."""

FLOORS = (
    ("bound", "regression"), ("standstill", "standstill"), ("repeats", "repeats"), ("force_white", "force sensor"),
    ("motion_sensors", "motion sensors"),
)  # fmt: skip
"""Estimates of the noise and their short names."""
TONES = {
    "adequate": "bold green",
    "missing_effect": "bold blue",
    "ambiguous": "bold yellow",
    "partial": "bold yellow",
    "unknown_effect": "bold red",
    "identified": "bold green",
    "identified_in_part": "bold yellow",
    "told_apart": "bold green",
    "revealed": "bold green",
    "one_way": "bold yellow",
    "not_told_apart": "bold red",
    "not_revealed": "bold red",
    "usable": "bold green",
    "not_usable": "bold red",
}
STATUS = {
    "present": "present",
    "confounded": "tied",
    "not_excited": "not excited",
    "absent": "absent",
}
STATUS_TONES = {
    "present": "bold blue",
    "confounded": "yellow",
    "not_excited": "dim",
    "absent": "dim",
}


def summary(view: View, report: Path | None = None) -> RenderableType:
    """At most 40 lines of 100 columns: verdict, candidates, falling error, where it fails.

    On a terminal in colour; elsewhere plain ASCII without colour codes.
    """
    return Summary(view, report)


@dataclass(frozen=True)
class Summary:
    """What `summary` returns: it looks at the console only when it is printed."""

    view: View
    report: Path | None

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """The parts, one below the other."""
        plain = not console.is_terminal or options.ascii_only
        pen = Pen(min(WIDTH, options.max_width), plain=plain)
        fleet = (fleet_lines, _notes)
        parts = fleet if self.view.command == "fleet" else (
            _head, _models, preflight_lines, parameter_lines, plan_lines, _candidates, _alternatives, _rest,
            _steps, _regions, _next, _notes,
        )  # fmt: skip
        lines = [line for part in parts for line in part(self.view, pen)]
        if self.report is not None:
            lines.append(pen.line(f"report: {self.report}"))
        yield Constrain(Group(*lines), pen.width)


def _head(view: View, pen: Pen) -> Iterator[RenderableType]:
    """Verdict and the error in newtons."""
    tone = TONES.get(str(view.result.get("verdict")), "bold")
    yield pen.line(pen.cut(f"{view.command} {view.model}: {verdict_title(view)}", pen.width), tone)
    yield pen.line(pen.cut(verdict_sentence(view), 2 * pen.width - 20))
    yield from (pen.line(pen.cut(said, pen.width)) for said in learnt(view))
    share = view.result.get("explainable")
    more = f"; explainable {percent(share)}" if share is not None else ""
    yield pen.line(view.headline + more)
    known = view.result.get("floors") or {}
    values = {name: (known.get(key) or {}).get("value") for key, name in FLOORS}
    said = [f"{name} {short(value)}" for name, value in values.items() if value is not None]
    if said:
        yield pen.line(f"noise by {', '.join(said)} N", "dim")


def _models(view: View, pen: Pen) -> Iterator[RenderableType]:
    """Several models side by side; of one, what its file tells of how it was made."""
    entries = list(view.result.get("models") or ())
    if not entries:
        made = [f"{change(view, e)} {fall(e)}".strip() for e in view.result.get("history") or ()]
        if made and view.command == "compare":
            yield pen.line(pen.cut(f"history: {'; '.join(made)}", pen.width), "dim")
        return
    rows = [
        [
            pen.cut(e["model"], pen.width - 52), pen.safe(newtons(e["rmse"])), pen.safe(percent(e["nrmse"])),
            pen.safe("" if k == 0 else against(e)), "fitted here" if e["fitted_to_these_data"] else "",
        ]
        for k, e in enumerate(entries[:MOST_MODELS])
    ]  # fmt: skip
    yield pen.line("")
    head = [
        ("model", ""),
        ("rms", "right"),
        ("NRMSE", "right"),
        ("against the first (90 %)", ""),
        ("", ""),
    ]
    yield pen.table(head, rows)
    if len(entries) > MOST_MODELS:
        yield pen.line(f"{len(entries) - MOST_MODELS} more models in the report", "dim")


def _candidates(view: View, pen: Pen) -> Iterator[RenderableType]:
    """The best candidates, with what chance reaches, and the parameters of what was taken."""
    entries = ranked(view)
    if not entries:
        return
    columns = [
        ("effect", ""),
        ("held out", "right"),
        ("size", "right"),
        ("p", "right"),
        ("status", ""),
    ]
    if pen.room >= LEAST_ROOM:
        columns.append(("parameters", ""))
    rows = [_row(view, e, pen)[: len(columns)] for e in entries[:MOST_CANDIDATES]]
    yield pen.line("")
    yield pen.table(columns, rows)
    more, chance = len(entries) - len(rows), limit(view)
    said = [f"{more} more candidates"] if more > 0 else []
    said += [f"chance alone reaches a size of {newtons(chance)}"] if chance is not None else []
    if said:
        yield pen.line("; ".join(said), "dim")
    never = [str(e["effect"]) for e in view.result.get("unknowable") or ()]
    if never:
        yield pen.line(f"cannot be known from these channels: {joined(never)}", "dim")
    for e in entries:
        if e["effect"] in (view.result.get("effects") or ()):
            values = ", ".join(
                f"{name} = {parameter(v)}" for name, v in (e.get("parameters") or {}).items()
            )
            yield pen.line(pen.cut(f"{title_of(view, str(e['effect']))}: {values}", pen.width))


def _row(view: View, e: Mapping[str, Any], pen: Pen) -> list[str | Text]:
    """Cells of one candidate; of the parameters, as many as there is room for."""
    size, status = effect_size(view, e), str(e.get("status", ""))
    cells = [
        pen.cut(title_of(view, str(e["effect"])), 24), pen.safe(newtons(e.get("rmse_held_out"))),
        gain(None if "basis" in e else size, largest(view)),
        pen.safe(short(e.get("p_value"), 2)),
    ]  # fmt: skip
    said = Text(
        STATUS.get(status, status), style="" if pen.plain else STATUS_TONES.get(status, "")
    )
    known = {k: v for k, v in (e.get("parameters") or {}).items() if v[1] is not None}
    values = [
        f"{name} {parameter(v, 1)}".replace(f" {PLUS_MINUS} ", PLUS_MINUS)
        for name, v in known.items()
    ]
    return [*cells, said, pen.fitting(values)]


def _alternatives(view: View, pen: Pen) -> Iterator[RenderableType]:
    """What cannot be told apart, and what to record."""
    experiments = {card.effect: card.experiment for card in view.candidates}
    for group in list(view.result.get("alternatives") or ())[:2]:
        names = joined([title_of(view, e) for e in group], "or")
        record = next((experiments[e] for e in group if experiments.get(e)), "")
        yield pen.line(
            pen.cut(
                f"cannot be told apart: {names}" + (f"; record: {record}" if record else ""),
                2 * pen.width,
            ),
            "yellow",
        )


def _rest(view: View, pen: Pen) -> Iterator[RenderableType]:
    """What the part that no known effect explains depends on."""
    rest = (view.result.get("unexplained") or {}).get("rest")
    if not rest or view.result.get("verdict") not in ("unknown_effect", "partial"):
        return
    for words in rest["says"][:3]:
        yield pen.line(pen.cut(f"the rest: {words}", pen.width), "yellow")


def _steps(view: View, pen: Pen) -> Iterator[RenderableType]:
    """The falling error as bars, down to the noise floor."""
    steps = view.result.get("steps") or []
    if len(steps) < 2:
        return
    names = ["model, refitted", *("+ " + title_of(view, str(s["added"])) for s in steps[1:])]
    errors = [float(s["rmse_held_out"]) for s in steps]
    if len(names) > MOST_STEPS:
        names, errors = (
            names[:1] + names[-MOST_STEPS + 1 :],
            errors[:1] + errors[-MOST_STEPS + 1 :],
        )
    floor = view.result.get("noise_floor")
    if floor is not None:
        names, errors = [*names, "noise floor"], [*errors, float(floor)]
    room, longest = pen.width - 46, max(errors)
    rows = [
        [
            pen.cut(name, 28),
            pen.safe(newtons(e)),
            pen.safe(BLOCK * max(round(room * e / longest), 1)),
        ]
        for name, e in zip(names, errors, strict=True)
    ]
    yield pen.line("")
    yield pen.table([("the error falls", ""), ("held out", "right"), ("", "")], rows)


def _regions(view: View, pen: Pen) -> Iterator[RenderableType]:
    """Where most of the error is; more of it where nothing was diagnosed."""
    found = worst(view.regions, 3 if view.candidates or "stages" in view.result else 6)
    if not found:
        return
    rows = [
        [
            pen.cut(where(r, single=single), 50),
            pen.safe(percent(r.share)),
            pen.safe(percent(r.of_samples)),
            pen.safe(newtons(r.rms)),
        ]
        for r, single in found
    ]
    yield pen.line("")
    yield pen.table(
        [
            ("where it fails", ""),
            ("of the error", "right"),
            ("of the data", "right"),
            ("rms", "right"),
        ],
        rows,
    )


def _next(view: View, pen: Pen) -> Iterator[RenderableType]:
    """What would plan the experiment that these data lack, ready to be pasted."""
    for command in view.result.get("next") or ():
        yield from map(pen.whole, pasteable(command, pen.width))


def pasteable(command: str, width: int) -> list[str]:
    """A command in lines of at most this width (longer words stay whole) that a shell takes for one when pasted."""
    lines, line = [], "next:"
    for word in map(shlex.quote, shlex.split(command)):
        if len(line) + len(word) + 3 > width:
            lines.append(f"{line} \\")
            line = "   "
        line = f"{line} {word}"
    return [*lines, line]


def _notes(view: View, pen: Pen) -> Iterator[RenderableType]:
    """The first notes, two lines each at most; more of them where data are missing."""
    said = view.result.get("reasons") or () if "stages" in view.result else ()
    notes = [note for note in dict.fromkeys(view.notes) if note not in said]
    most = MOST_NOTES if view.result.get("complete", True) else MOST_NOTES_INCOMPLETE
    for note in notes[:most]:
        first, *rest = textwrap.wrap(f"note: {note}", pen.width) or [""]
        yield pen.line(first, "dim")
        if rest:
            yield pen.line(pen.cut(" ".join(rest), pen.width), "dim")
    more = len(notes) - most
    if more > 0:
        yield pen.line(f"{more} more note{'s' * (more > 1)} in --json and --report", "dim")
