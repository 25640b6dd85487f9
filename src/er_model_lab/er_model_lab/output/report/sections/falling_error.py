"""The falling error: from the model as it was, effect by effect, down to the noise."""

from __future__ import annotations

import numpy as np

from er_model_lab.output.report.figure import Axis, Bars, Figure, Level, Panel
from er_model_lab.output.report.palette import AFTER, BEFORE, FLOOR
from er_model_lab.output.report.section import Section
from er_model_lab.output.text.units import newtons, percent
from er_model_lab.output.text.verdict_text import title_of
from er_model_lab.view import Array, View

TAKEN = "#f2c9a8"
"""Colour of what an effect takes off the error."""


def section(view: View) -> Section | None:
    """Waterfall of the rms error on held-out data; None when nothing was added."""
    steps = view.result.get("steps") or []
    if len(steps) < 2:
        return None
    names = ["model, refitted", *("+ " + title_of(view, str(s["added"])) for s in steps[1:])]
    errors = np.array([float(s["rmse_held_out"]) for s in steps])
    figure = _waterfall(names, errors, view.result.get("noise_floor"))
    fall = percent(1.0 - errors[-1] / errors[0])
    return Section(
        "falling_error",
        "The error falls",
        (figure,),
        {"fall": fall, "start": newtons(errors[0]), "end": newtons(errors[-1])},
    )


def _waterfall(names: list[str], errors: Array, floor: float | None) -> Figure:
    """One bar where it starts, one floating bar per step, one bar where it ends."""
    n = errors.size
    falls = errors[:-1] - errors[1:]
    marks: list[Bars | Level] = [
        Bars(np.array([0.0]), errors[:1], "error of the model", (BEFORE,), width=0.6),
        Bars(
            np.arange(1.0, n), falls, "taken away", (TAKEN,) * (n - 1), base=errors[1:], width=0.6
        ),
        Bars(np.array([float(n)]), errors[-1:], "error that remains", (AFTER,), width=0.6),
    ]
    if floor is not None:
        marks.append(Level(float(floor), f"noise floor {newtons(float(floor))}", FLOOR))
    values = [newtons(errors[0]), *(newtons(-f) for f in falls), newtons(errors[-1])]
    named = zip([*names, "remains"], values, strict=True)
    ticks = tuple((float(k), f"{name}\n{value}") for k, (name, value) in enumerate(named))
    top = 1.08 * float(np.max(errors))
    panel = Panel(
        tuple(marks), Axis(ticks=ticks), Axis("rms error on held-out data [N]", (0.0, top))
    )
    words = ", ".join(f"{name} {newtons(float(e))}" for name, e in zip(names, errors, strict=True))
    return Figure(
        "falling_error", f"Waterfall of the error on held-out data: {words}.", (panel,), height=340
    )
