"""One screen of summary for a terminal, and the same as plain ASCII for a file or a pipe."""

from __future__ import annotations

import shlex
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
from er_model_lab.output.terminal.heat_map import heat_map
from er_model_lab.output.terminal.markup import BLOCK, Pen
from er_model_lab.output.terminal.parameters import parameter_lines
from er_model_lab.output.terminal.plan import plan_lines
from er_model_lab.output.terminal.preflight import preflight_lines
from er_model_lab.output.text.fall import stages
from er_model_lab.output.text.notes import SMALL, by_weight, weight
from er_model_lab.output.text.ranking import beside, chance_says, effect_size, ranked
from er_model_lab.output.text.regions import ALWAYS, NOTABLE, failures
from er_model_lab.output.text.units import gain, newtons, percent, short, where
from er_model_lab.output.text.verdict_text import (
    beyond_noise,
    joined,
    learnt,
    standing,
    standing_words,
    title_of,
    verdict_sentence,
    verdict_title,
)
from er_model_lab.view import View

WIDTH = 100
MOST_CANDIDATES = 5
MOST_REGIONS = 6
MOST_NOTES, MOST_DECISIVE = 3, 6
"""Notes that are shown, and where more of them change the result."""
MOST_MODELS = 10

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
STATUS_TONES = {
    "present": "bold blue",
    "confounded": "yellow",
    "not_excited": "dim",
    "absent": "dim",
    "outdone": "dim",
    "minor": "yellow",
}


def summary(view: View, report: Path | None = None) -> RenderableType:
    """Lines of at most 100 columns: verdict, candidates, falling error, parameters, where it fails, notes.

    Nothing that decides is cut: what is longer than a line goes on in the next.

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
            _head, _models, preflight_lines, plan_lines, _candidates, _alternatives, _rest,
            _steps, parameter_lines, _regions, heat_map, _next, _notes,
        )  # fmt: skip
        lines = [line for part in parts for line in part(self.view, pen)]
        if self.report is not None:
            lines.append(pen.line(f"report: {self.report}"))
        yield Constrain(Group(*lines), pen.width)


def _head(view: View, pen: Pen) -> Iterator[RenderableType]:
    """Verdict and the error in newtons."""
    tone = TONES.get(str(view.result.get("verdict")), "bold")
    yield pen.line(f"{view.command} {view.model}: {verdict_title(view)}", tone)
    yield pen.line(verdict_sentence(view))
    yield from map(pen.line, learnt(view))
    share, split = beyond_noise(view), isinstance(view.result.get("rmse"), Mapping)
    whose = "refitted, on held-out data: " if split and share is not None else ""
    more = f"; explainable {percent(share)}" if share is not None else ""
    yield pen.line(whose + view.headline + more)
    known = view.result.get("floors") or {}
    values = {name: (known.get(key) or {}).get("value") for key, name in FLOORS}
    where_of = {"regression": " on held-out data"} if split else {}
    said = [f"{k}{where_of.get(k, '')} {short(v)}" for k, v in values.items() if v is not None]
    if said:
        yield pen.line(f"noise by {', '.join(said)} N", "dim")


def _models(view: View, pen: Pen) -> Iterator[RenderableType]:
    """Several models side by side; of one, what its file tells of how it was made."""
    entries = list(view.result.get("models") or ())
    if not entries:
        made = [f"{change(view, e)} {fall(e)}".strip() for e in view.result.get("history") or ()]
        if made and view.command == "compare":
            yield pen.line(f"history: {'; '.join(made)}", "dim")
        return
    rows = [
        [
            pen.safe(e["model"]), pen.safe(newtons(e["rmse"])), pen.safe(percent(e["nrmse"])),
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
        ("", ""),
    ]
    taken = len(view.result.get("effects") or ())
    rows = [_row(view, e, pen) for e in entries[: max(taken, MOST_CANDIDATES)]]
    yield pen.line("")
    yield pen.table(columns, rows)
    more, chance = len(entries) - len(rows), chance_says(view)
    said = [f"{more} more candidates"] if more > 0 else []
    said += [chance] if chance else []
    if said:
        yield pen.line("; ".join(said), "dim")
    never = [str(e["effect"]) for e in view.result.get("unknowable") or ()]
    if never:
        yield pen.line(f"cannot be known from these channels: {joined(never)}", "dim")


def _row(view: View, e: Mapping[str, Any], pen: Pen) -> list[str | Text]:
    """Cells of one candidate."""
    size, tone = effect_size(view, e), "" if pen.plain else STATUS_TONES.get(standing(e), "")
    return [
        pen.safe(title_of(view, str(e["effect"]))), pen.safe(newtons(e.get("rmse_held_out"))),
        gain(None if "basis" in e else size, beside(view, e)),
        pen.safe(short(e.get("p_value"), 2)), Text(pen.safe(standing_words(view, e)), style=tone),
    ]  # fmt: skip


def _alternatives(view: View, pen: Pen) -> Iterator[RenderableType]:
    """What cannot be told apart, and what to record."""
    experiments = {card.effect: card.experiment for card in view.candidates}
    for group in list(view.result.get("alternatives") or ())[:2]:
        names = joined([title_of(view, e) for e in group], "or")
        record = next((experiments[e] for e in group if experiments.get(e)), "")
        then = f"; record: {record}" if record else ""
        yield pen.line(f"cannot be told apart: {names}{then}", "yellow")


def _rest(view: View, pen: Pen) -> Iterator[RenderableType]:
    """What the part that no known effect explains depends on."""
    rest = (view.result.get("unexplained") or {}).get("rest")
    if not rest or view.result.get("verdict") not in ("unknown_effect", "partial"):
        return
    for words in rest["says"][:3]:
        yield pen.line(f"the rest: {words}", "yellow")


def _steps(view: View, pen: Pen) -> Iterator[RenderableType]:
    """The error of every model on the way as bars, down to the noise floor; of a pair, each of the two alone."""
    found = stages(view)
    if not found:
        return
    rows = [
        row
        for s in found
        for row in [(s.name, s.error), *((f"  {name} alone", e) for name, e in s.alone)]
    ]
    floor = view.result.get("noise_floor")
    rows += [("noise floor", float(floor))] if floor is not None else []
    room, longest = pen.width - 46, max(e for _, e in rows)
    bars = [BLOCK * max(round(room * e / longest), 1) for _, e in rows]
    cells = [
        [pen.safe(name), pen.safe(newtons(e)), pen.safe(bar)]
        for (name, e), bar in zip(rows, bars, strict=True)
    ]
    yield pen.line("")
    yield pen.table([("the error falls", ""), ("held out", "right"), ("", "left")], cells)


def _regions(view: View, pen: Pen) -> Iterator[RenderableType]:
    """Where most of the error is of the last model; of one that was grown, where it was before as well."""
    tables = view.regions_after or view.regions
    found = failures(tables, view.records, after=bool(view.regions_after), most=MOST_REGIONS)
    if not found:
        return
    rows = [
        [
            pen.safe(where(f.region, single=f.single)), pen.safe(percent(f.region.share)),
            pen.safe(percent(f.region.of_samples)), pen.safe(newtons(f.region.rms)),
            pen.safe(f"{f.when[0]}, {f.when[1]:.0f} s" if f.when else ""),
        ]
        for f in found
    ]  # fmt: skip
    even = all(
        f.region.share <= NOTABLE * f.region.of_samples and f.region.excess < f.region.floor
        for f in found
    )
    title = "where most of the rest is" if even else "where it fails"
    title = "where it still fails" if view.regions_after and not even else title
    numbers = [(name, "right") for name in ("of the error", "of the data", "rms")]
    yield pen.line("")
    yield pen.table([(title, ""), *numbers, ("worst second", "")], rows)
    if view.regions_after:
        was = failures(view.regions, view.records, after=False, most=len(ALWAYS))
        said = [
            f"{where(f.region, single=f.single)} ({newtons(f.region.rms)}, {percent(f.region.share)})"
            for f in was
        ]
        yield pen.line(f"where it failed before: {'; '.join(said)}", "dim")


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
    """The notes that change the result, then as many of the others as there is room for, all in full."""
    said = view.result.get("reasons") or () if "stages" in view.result else ()
    notes = [note for note in by_weight(view.notes) if note not in said]
    # of incomplete data what happened to them changes the result
    small = SMALL if view.result.get("complete", True) else SMALL + 1
    decisive = sum(weight(note) < small for note in notes)
    shown = notes[: min(max(decisive, MOST_NOTES), MOST_DECISIVE)]
    for note in shown:
        yield pen.line(f"note: {note}", "dim")
    more = len(notes) - len(shown)
    if more > 0:
        yield pen.line(f"{more} more note{'s' * (more > 1)} in --json and --report", "dim")
