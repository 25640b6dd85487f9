"""Parameters before and after with what the data say of each; correlation and response time where identified."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from er_model_lab.output.report.figure import Axis, Figure, Line, Mark, Panel, Points, Scale, Tiles
from er_model_lab.output.report.palette import AFTER, BEFORE, CORRELATION, MEASURED, STATUS
from er_model_lab.output.report.section import Section
from er_model_lab.output.text.units import estimate, newtons, parameter, short
from er_model_lab.view import Array, View

SAID: dict[str, tuple[str, str]] = {
    "identified": ("identified", STATUS["present"]),
    "weak": ("weakly visible", STATUS["confounded"]),
    "conditional": ("for what was held", STATUS["confounded"]),
    "at_bound": ("at its bound", STATUS["confounded"]),
    "not_identified": ("not determined", STATUS["not_excited"]),
    "given": ("given, not fitted", STATUS["absent"]),
    "added": ("new", AFTER),
}
"""Status of a parameter in words, and its colour."""
STAGES: dict[str, str] = {
    "linear": "passive terms, without field",
    "yield": "yield force, static law",
    "response": "yield force with its response time",
}
"""Stage in words."""


def section(view: View) -> Section | None:
    """Parameters, and of an identification stages and pictures; None where nothing was fitted."""
    result = view.result
    if not result.get("parameters"):
        return None
    stages = result.get("stages") or ()
    figures = (
        tuple(f for f in (_correlation(result), _response(result)) if f is not None)
        if stages
        else ()
    )
    facts = {"rows": list(rows(result)), "stages": [_stage(s) for s in stages]}
    return Section("identified", "Parameters", figures, facts)


def entries(result: Mapping[str, Any]) -> Iterator[tuple[str, str, Mapping[str, Any]]]:
    """Effect, name and entry of every parameter, in the order of the model."""
    for effect, values in result["parameters"].items():
        for name, entry in values.items():
            yield effect, name, entry


def rows(result: Mapping[str, Any]) -> Iterator[dict[str, str]]:
    """One row a parameter."""
    for effect, name, entry in entries(result):
        said, colour = SAID[entry["status"]]
        visible = entry.get("visible")
        before, value, bounds = estimate(entry)
        yield {
            "name": name, "effect": effect.replace("_", " "), "value": value, "before": before, "bounds": bounds,
            "status": said, "colour": colour,
            "visible": newtons(visible) if visible is not None else "",
        }  # fmt: skip


def _stage(stage: Mapping[str, Any]) -> dict[str, Any]:
    """One stage: its values, or why it was left out."""
    values = [f"{k.split('.')[1]} {parameter(v)}" for k, v in stage.get("parameters", {}).items()]
    return {
        "name": STAGES[stage["stage"]], "values": "; ".join(values), "why": stage.get("why", ""),
        "samples": stage.get("samples", ""), "rmse": newtons(stage.get("rmse")),
    }  # fmt: skip


def _correlation(result: Mapping[str, Any]) -> Figure | None:
    """Correlation of the estimates as a map."""
    names = [n.split(".")[1] for n in result["correlation"]["names"]]
    matrix = [[np.nan if c is None else c for c in row] for row in result["correlation"]["matrix"]]
    n = len(names)
    if n < 2:
        return None
    z = np.array(matrix, float)
    edges: Array = np.arange(n + 1.0) - 0.5
    ticks = tuple((float(k), name) for k, name in enumerate(names))
    apart = np.abs(np.where(np.eye(n, dtype=bool), 0.0, np.nan_to_num(z)))
    i, k = np.unravel_index(int(np.argmax(apart)), z.shape)
    alt = f"Correlation of the estimates; the closest pair is {names[i]} and {names[k]} with {z[i, k]:.2f}."
    panel = Panel((Tiles(edges, edges, z),), Axis(ticks=ticks), Axis(ticks=ticks))
    scale = Scale("correlation", -1.0, 1.0, CORRELATION)
    width = max(620, 170 + 52 * n)
    return Figure(
        "correlation",
        alt,
        (panel,),
        height=150 + 28 * n,
        width=width,
        scale=scale,
        interactive=False,
    )


def _response(result: Mapping[str, Any]) -> Figure | None:
    """Response time at each duty with two deviations, the model's law, and the quadratic (1.21)."""
    response = result.get("response_time")
    if not response:
        return None
    duty, tau, sd = (
        np.array([level[k] if level[k] is not None else np.nan for level in response["levels"]])
        for k in ("duty", "tau", "sd")
    )
    law = response["model"]
    u = np.array(law["duty"])
    bars_x = np.repeat(duty, 3)
    bars_y = 1e3 * np.ravel(
        np.column_stack([tau - 2 * sd, tau + 2 * sd, np.full(tau.size, np.nan)])
    )
    marks: list[Mark] = [Line(u, 1e3 * np.array(law["tau"]), "model", AFTER, 2.0)]
    if response["quadratic"]:
        c = [response["quadratic"][f"tau_{k}"][0] for k in range(3)]
        curve = 1e3 * (c[0] + c[1] * u + c[2] * u**2)
        marks.append(Line(u, curve, "quadratic (1.21)", BEFORE, 1.3, "dash"))
    marks += [
        Line(bars_x, bars_y, "", MEASURED, 1.6),
        Points(duty, 1e3 * tau, "levels, \N{PLUS-MINUS SIGN}2 sd", MEASURED, 7.0, 1.0),
    ]
    said = ", ".join(
        f"{1e3 * y:.1f} ms at {short(float(x))}" for x, y in zip(duty, tau, strict=True)
    )
    panel = Panel(
        tuple(marks),
        Axis("duty"),
        Axis("response time [ms]", (0.0, 1.15e3 * float(np.nanmax(tau)))),
    )
    return Figure(
        "response_time", f"Response time over the duty: {said}.", (panel,), height=340, width=620,
        interactive=False,
    )  # fmt: skip
