"""The noise floor from several sides, side by side."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from er_model_lab.output.report.figure import Axis, Bars, Figure, Level, Panel
from er_model_lab.output.report.palette import BEFORE, FLOOR, RESIDUAL
from er_model_lab.output.report.section import Section
from er_model_lab.output.text.units import newtons
from er_model_lab.output.text.verdict_text import rmse
from er_model_lab.view import View

NAMES: dict[str, str] = {
    "standstill": "at standstill",
    "standstill_and_motion_sensors": "standstill and motion sensors",
    "repeats": "repeated motion",
    "force_white": "white noise of the force",
    "motion_sensors": "motion sensors, through the model",
    "bound": "bound on held-out data: what no regression explains",
    "bound_train": "the same on training data",
}
"""Plain names of the estimates."""


def section(view: View) -> Section | None:
    """All estimates as a table and as bars beside the error; None where none were made."""
    found = view.result.get("floors") or {}
    known = {NAMES[k]: f for k, f in found.items() if f["value"] is not None}
    if not known:
        return None
    rows = [(NAMES[k], _value(f), f["says"]) for k, f in found.items()]
    figure = _figure(
        known,
        rmse(view.result),
        view.result.get("noise_floor"),
        split=isinstance(view.result.get("rmse"), Mapping),
    )
    return Section("noise", "The noise", (figure,), {"rows": rows})


def _value(f: Mapping[str, Any]) -> str:
    """A value with its deviation, or a dash."""
    if f["value"] is None:
        return "-"
    sd = f" \N{PLUS-MINUS SIGN} {newtons(f['sd'])}" if f["sd"] is not None else ""
    return newtons(f["value"]) + sd


def _figure(
    known: Mapping[str, Mapping[str, Any]], error: float | None, used: float | None, *, split: bool
) -> Figure:
    """Horizontal bars with two deviations, the error beside them."""
    n = len(known)
    at = np.arange(float(n))[::-1]
    size = np.array([float(f["value"]) for f in known.values()])
    sd = np.array([float(f["sd"] or 0.0) for f in known.values()])
    ends = np.array([np.maximum(size - 2.0 * sd, 0.0), size + 2.0 * sd])
    marks: list[Bars | Level] = [
        Bars(at, size, "", (RESIDUAL,) * n, ends=ends, horizontal=True, width=0.66)
    ]
    if used is not None:
        marks.append(Level(float(used), f"noise floor used {newtons(used)}", FLOOR, vertical=True))
    if error is not None:
        marks.append(
            Level(
                float(error),
                f"error on held-out data {newtons(error)}" if split else f"error {newtons(error)}",
                BEFORE,
                "solid",
                vertical=True,
            )
        )
    ticks = tuple((float(a), name) for a, name in zip(at, known, strict=True))
    top = 1.1 * max(float(ends[1].max()), error or 0.0)
    panel = Panel(
        tuple(marks), Axis("newtons [N]", (0.0, top)), Axis(ticks=ticks, span=(-0.6, n - 0.4))
    )
    words = ", ".join(f"{name} {newtons(float(f['value']))}" for name, f in known.items())
    return Figure("noise", f"Estimates of the noise: {words}.", (panel,), height=120 + 34 * n)
