"""The falling error: from the model as given, refitted, then step by step, down to the noise."""

from __future__ import annotations

import textwrap

import numpy as np

from er_model_lab.output.report.figure import Axis, Bars, Figure, Level, Panel
from er_model_lab.output.report.palette import AFTER, BEFORE, FLOOR
from er_model_lab.output.report.section import Section
from er_model_lab.output.text.fall import Stage, stages
from er_model_lab.output.text.units import moves, newtons, percent
from er_model_lab.view import Array, View

TAKEN, RISEN = "#f2c9a8", "#cc79a7"
"""Colours of what a step takes off the error, and of what it puts on."""
ROOM = 100
"""Characters of all names below the bars before they go on in the next line."""


def section(view: View) -> Section | None:
    """Waterfall of the rms error on held-out data, and its numbers; None where nothing changed the model."""
    found = stages(view)
    if not found:
        return None
    figure = _waterfall(found, view.result.get("noise_floor"))
    first, last = found[0].error, found[-1].error
    fall = moves(first, last)
    facts = {
        "fall": fall, "by": percent(1.0 - last / first) if fall.startswith("falls") else "",
        "rows": [_row(a, b) for a, b in zip((None, *found), found, strict=False)],
    }  # fmt: skip
    return Section("falling_error", "The error falls", (figure,), facts)


def _row(before: Stage | None, s: Stage) -> tuple[str, str, str, list[str]]:
    """A model, its error, what that did, and of a pair what each of the two adds to the other one."""
    adds = [
        f"{b} beside {a}: {moves(left, s.error)}"
        for (a, left), (b, _) in zip(s.alone, s.alone[::-1], strict=True)
    ]
    return s.name, newtons(s.error), moves(before.error, s.error) if before else "", adds


def _waterfall(found: tuple[Stage, ...], floor: float | None) -> Figure:
    """One bar where it starts, one floating bar per step, one bar where it ends."""
    errors = np.array([s.error for s in found])
    n, falls = errors.size, errors[:-1] - errors[1:]
    marks: list[Bars | Level] = [
        Bars(np.array([0.0]), errors[:1], "error of the model", (BEFORE,), width=0.6),
        *_floating(errors, falls > 0.0, "taken away", TAKEN),
        *_floating(errors, falls < 0.0, "error rises", RISEN),
        Bars(np.array([float(n)]), errors[-1:], "error that remains", (AFTER,), width=0.6),
    ]
    if floor is not None:
        marks.append(Level(float(floor), f"noise floor {newtons(float(floor))}", FLOOR))
    signed = [("+" if f < 0.0 else "") + newtons(-f) for f in falls]
    values = [newtons(errors[0]), *signed, newtons(errors[-1])]
    names = [s.name for s in found]
    named = zip([*names, "remains"], values, strict=True)
    ticks = tuple(
        (float(k), f"{textwrap.fill(name, ROOM // (n + 1))}\n{value}")
        for k, (name, value) in enumerate(named)
    )
    top = 1.08 * max(float(np.max(errors)), floor or 0.0)
    panel = Panel(
        tuple(marks), Axis(ticks=ticks), Axis("rms error on held-out data [N]", (0.0, top))
    )
    words = ", ".join(f"{s.name} {newtons(s.error)}" for s in found)
    return Figure(
        "falling_error", f"Waterfall of the error on held-out data: {words}.", (panel,), height=340
    )


def _floating(errors: Array, rows: Array, name: str, colour: str) -> list[Bars]:
    """The steps of one direction as bars between the errors before and after."""
    at = np.flatnonzero(rows)
    if not at.size:
        return []
    low, high = np.minimum(errors[at], errors[at + 1]), np.maximum(errors[at], errors[at + 1])
    return [Bars(np.asarray(at + 1.0), high - low, name, (colour,) * at.size, base=low, width=0.6)]
