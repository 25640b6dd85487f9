"""The page of chapter 6: faults, the duties that mimic them (figures 6.1 to 6.9), forces left (6.10, 6.12)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from er_common.versions import versions
from er_model_lab.output.report.figure import Axis, Dash, Figure, Line, Panel, Points
from er_model_lab.output.report.palette import AFTER, BEFORE, FLOOR, MEASURED, MUTED
from er_model_lab.output.report.section import Section
from er_model_lab.output.report.sections import provenance
from er_model_lab.view import View

from er_studies.command_line import command_line
from er_studies.thesis import chapter_6_text as present
from er_studies.thesis.chapter_6 import LEAK, Case, Chapter6

TITLES = {
    "electrical": "Electrical faults (figures 6.1 to 6.3)",
    "leakage": "Oil leakage (figures 6.4 to 6.6)",
    "deformation": "Physical deformation (figures 6.7 to 6.9)",
    "combined": "All three at once, (6.8)",
    "heavy": "The leak of section 6.4",
}
DASHES: tuple[Dash, Dash] = ("solid", "dot")
"""Of the most and the least force."""
SHOWN = 1.0
"""Stretch shown at first [s]."""


def view(found: Chapter6, data: Mapping[str, Any]) -> View:
    """What the page needs beside its sections."""
    known = {
        "damper": found.model.digest(),
        "versions": versions(),
        "command_line": command_line(),
    }
    return View("thesis", "chapter 6", "", result=data, records=(), notes=(), provenance=known)


def sections(found: Chapter6, data: Mapping[str, Any]) -> list[Section]:
    """All sections of the page."""
    made = [_mimic(found, case) for case in found.cases]
    made.append(_domain(found))
    last = provenance.section(view(found, data))
    return [*made, last] if last else made


def _mimic(found: Chapter6, case: Case) -> Section:
    """Duty, forces over time, force over velocity."""
    t, v = found.t, 1e3 * found.v
    none = np.where(case.mimic.exists, np.nan, case.mimic.duty)
    middle = float(t[t.size // 2])
    span = (middle - 0.5 * SHOWN, middle + 0.5 * SHOWN)
    panels = (
        Panel(
            (
                Line(t, found.duty, "of the faulty damper", MUTED),
                Line(t, case.mimic.duty, "that mimics it", AFTER),
                Points(t, none, "no duty can", BEFORE, 3.0, 0.8),
            ),
            Axis(span=span),
            Axis("duty"),
        ),
        Panel(
            (
                Line(t, found.healthy, "healthy", MUTED),
                Line(t, case.faulty, "faulty", MEASURED),
                Line(t, case.copied, "mimic", AFTER, dash="dash"),
            ),
            Axis("time [s]", span),
            Axis("force [N]"),
        ),
    )
    over_time = Figure(
        f"{case.name}_time", "Duty and force over time: healthy, faulty, and healthy at the mimicking duty.",
        panels, height=480, heights=(1.0, 1.5), linked=True,
    )  # fmt: skip
    dots = (
        Points(v, found.healthy, "healthy", MUTED, 3.0, 0.5),
        Points(v, case.faulty, "faulty", MEASURED, 3.0, 0.5),
        Points(v, case.copied, "mimic", AFTER, 3.0, 0.5),
    )
    loops = Figure(
        f"{case.name}_loops", "Force over velocity: healthy, faulty, mimic.",
        (Panel(dots, Axis("velocity [mm/s]"), Axis("force [N]")),), height=420,
    )  # fmt: skip
    text = (
        f"A duty from 0 to 1 mimics the fault at {100 * case.exists:.1f} % of the samples; elsewhere the healthy "
        "damper's own passive force is already more than the faulty one gives, and the nearest duty is held.",
    )
    row = [r for r in present.rows(found) if r[0] == case.name]
    facts = {"text": text, "head": present.HEAD, "rows": row}
    return Section(case.name, TITLES[case.name], (over_time, loops), facts, "prose")


def _domain(found: Chapter6) -> Section:
    """Figures 6.10 and 6.12."""
    over = 1e3 * found.velocity
    names = ("healthy", f"f2 = {LEAK.leakage:g}")
    ideal = tuple(
        Line(over, end, f"{name}, {which}", colour, dash=dash)
        for name, domain, colour in zip(names, found.ideal, (MEASURED, FLOOR), strict=True)
        for which, end, dash in zip(
            ("most", "least"), (domain.high, domain.low), DASHES, strict=True
        )
    )
    real = tuple(
        Points(1e3 * found.v, end, f"{name}, {which}", colour, 3.0, 0.6)
        for name, domain, colours in zip(
            names, found.real, ((MEASURED, MUTED), (FLOOR, AFTER)), strict=True
        )
        for which, end, colour in zip(
            ("most", "least"), (domain.high, domain.low), colours, strict=True
        )
    )
    axes = Axis("velocity [mm/s]"), Axis("force [N]")
    panels = (
        Panel(ideal, *axes, "at zero deflection (6.10)"),
        Panel(real, *axes, "on the ride (6.12)"),
    )  # type: ignore[arg-type]
    figure = Figure(
        "domain", "Forces a damper can give, healthy and leaking.", panels, 2, height=420
    )
    text = (
        "Every force lies between that of duty 0 and that of duty 1. A leak makes the domain smaller and turns it; "
        "the stiffness of the gas lets it stand above and below zero at once.",
    )
    return Section(
        "domain", "Dissipativity domain", (figure,), {"text": text, "rows": ()}, "prose"
    )
