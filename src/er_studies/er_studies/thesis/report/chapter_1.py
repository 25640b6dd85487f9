"""The page of chapter 1: Table 1.5, the response time over the duty, and the pictures of the four cases."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from er_common.versions import versions
from er_model_lab.identification.law import response_time as response_time_of
from er_model_lab.output.report.figure import Axis, Figure, Line, Panel, Points
from er_model_lab.output.report.palette import AFTER, BEFORE, FLOOR, MEASURED, MUTED
from er_model_lab.output.report.samples import margin
from er_model_lab.output.report.section import Section
from er_model_lab.output.report.sections import provenance
from er_model_lab.output.report.thin import every
from er_model_lab.view import Array, View

from er_studies.command_line import command_line
from er_studies.thesis.chapter_1 import LAWS, Case, Chapter1
from er_studies.thesis.chapter_1_text import (
    CASE_2_HEAD,
    HEAD,
    STAND_IN,
    WAYS_HEAD,
    static_against_dynamic,
    table_1_5,
    ways,
)

COLOURS = {"bingham": BEFORE, "guo": AFTER}
NAMES = {"bingham": "extended Bingham", "guo": "extended Guo"}
SHOWN = 2.0
"""Seconds of a record that a picture shows first."""
MOST_DOTS = 1500


def view(found: Chapter1, data: Mapping[str, Any]) -> View:
    """What the page needs beside its sections."""
    known = {
        "seed": data["seed"],
        "damper": found.truth.digest(),
        "versions": versions(),
        "command_line": command_line(),
    }
    return View("thesis", "chapter 1", "", data, (), notes=(STAND_IN,), provenance=known)


def sections(found: Chapter1, data: Mapping[str, Any]) -> list[Section]:
    """All sections of the page."""
    made = [
        _table_1_5(found),
        _response_time(found),
        _case_1(found.tests),
        _case_2(found.tests),
        _validation(found.validation["bumps"], "case_3", "Case 3: sinusoidal bumps, duty 0.2"),
        _validation(found.validation["iso"], "case_4", "Case 4: ISO 8608 road, duty 0.225"),
        _ways(found),
    ]
    last = provenance.section(view(found, data))
    return [*made, last] if last else made


def _table_1_5(found: Chapter1) -> Section:
    """The thesis's errors beside ours."""
    text = (
        STAND_IN,
        "NRMSE is the rms error over the range of the measured force. The last column is what the simulated damper "
        "itself leaves on the measured motion: no model can do better.",
    )
    facts = {"text": text, "head": HEAD, "rows": table_1_5(found)}
    return Section("table_1_5", "Table 1.5", facts=facts, template="prose")


def _ways(found: Chapter1) -> Section:
    """What each step of the identification changes."""
    text = (
        "Stage by stage is the procedure of section 1.5; all parameters together is the refinement after it. "
        "The motion is fused from all sensors, but for one row. Static: the yield stage alone. The last row "
        "has one effect more than the thesis's model.",
    )
    facts = {"text": text, "head": WAYS_HEAD, "rows": ways(found)}
    return Section("ways", "Ways of identification", facts=facts, template="prose")


def _response_time(found: Chapter1) -> Section:
    """Figure 1.17: response time over the duty."""
    duty = np.linspace(0.0, 0.35, 71)
    marks: list[Line | Points] = [
        Line(duty, 1e3 * response_time_of(found.truth, duty), "measured damper", MEASURED)
    ]
    printed = response_time_of(found.polynomial, duty)
    marks.append(Line(duty, 1e3 * printed, "thesis (1.21)", MUTED, dash="dash"))
    for law, identified in found.identified.items():
        table = identified.table
        if table is not None:
            colour = COLOURS[law]
            marks.append(Points(table.duty, 1e3 * table.tau, NAMES[law], colour, 7.0, 1.0))
            for u, tau, sd in zip(table.duty, table.tau, table.sd, strict=True):
                ends = 1e3 * (tau + 2.0 * sd * np.array([-1.0, 1.0]))
                marks.append(Line(np.array([u, u]), ends, "", colour))
    panel = Panel(tuple(marks), Axis("duty"), Axis("response time [ms]"))
    alt = "Response time over the duty: of the measured damper, as identified with both models, and (1.21)."
    text = ("Dots: identified at each constant duty, with two standard deviations.",)
    return Section(
        "response_time", "Response time", (Figure("response_time", alt, (panel,), height=380),),
        {"text": text, "rows": ()}, "prose",
    )  # fmt: skip


def _case_1(case: Case) -> Section:
    """Loops of the identification data, measured and by each model."""
    figure = _loops(case, "case_1", height=680)
    text = (
        "The yield tests from which the models were identified: five duties, three sines each.",
    )
    return Section(
        "case_1", "Case 1: loops", (figure,), {"text": text, "rows": ()}, template="prose"
    )


def _case_2(case: Case) -> Section:
    """Static against dynamic over time, a few turns of the motion at the highest duty."""
    t, first = case.motion.t, case.motion.t[-1] - SHOWN / 2.0
    span = Axis(span=(float(first), float(t[-1])))
    panels = []
    for law in LAWS:
        force = (
            Line(t, case.force, "measured", MEASURED, 1.1),
            Line(t, case.forces[f"{law}_static"], "static", FLOOR),
            Line(t, case.forces[law], "dynamic", AFTER),
        )
        panels.append(Panel(force, span, Axis("force [N]"), NAMES[law]))
    velocity = (Line(t, 1e3 * case.motion.v, "", MUTED, 1.0),)
    panels.append(Panel(velocity, Axis("time [s]", span.span), Axis("v [mm/s]")))
    alt = "Measured force, static and dynamic model over time; they part around zero velocity."
    figure = Figure("case_2", alt, tuple(panels), height=680, heights=(2.0, 2.0, 1.0), linked=True)
    facts = {
        "text": ("Turning: the tenth of the velocity range around zero.",),
        "head": CASE_2_HEAD,
        "rows": static_against_dynamic(case),
    }
    return Section("case_2", "Case 2: static against dynamic", (figure,), facts, template="prose")


def _validation(case: Case, key: str, title: str) -> Section:
    """Road, force and error over time, and the loops."""
    t = case.motion.t
    middle = float(t[t.size // 2])
    span = (middle, middle + SHOWN)
    force = [Line(t, case.force, "measured", MEASURED, 1.1)]
    force += [Line(t, case.forces[law], NAMES[law], COLOURS[law]) for law in LAWS]
    left = [Line(t, case.force - case.forces[law], NAMES[law], COLOURS[law]) for law in LAWS]
    panels = (
        Panel((Line(t, 1e3 * case.road, "", MUTED),), Axis(span=span), Axis("road [mm]")),
        Panel(tuple(force), Axis(span=span), Axis("force [N]")),
        Panel(tuple(left), Axis("time [s]", span), Axis("error [N]")),
    )
    alt = f"{title}: road, measured force and both models, and their errors over time."
    over_time = Figure(key, alt, panels, height=640, heights=(1.0, 2.5, 1.5), linked=True)
    errors = ", ".join(f"{NAMES[law]} {case.nrmse(law):.4f}" for law in LAWS)
    facts = {"text": (f"NRMSE: {errors}; what was measured itself {case.nrmse('truth'):.4f}.",)}
    return Section(
        key, title, (over_time, _loops(case, f"{key}_loops", height=600)), {**facts, "rows": ()},
        template="prose",
    )  # fmt: skip


def _loops(case: Case, name: str, height: int) -> Figure:
    """Force over deflection and over velocity, one row per model."""
    rows = np.flatnonzero(case.scored)
    rows = rows[every(rows.size, MOST_DOTS)]
    ends = margin(case.force[rows], *(case.forces[law][rows] for law in LAWS))
    planes: tuple[tuple[str, Array], ...] = (
        ("deflection [mm]", 1e3 * case.motion.x[rows]),
        ("velocity [mm/s]", 1e3 * case.motion.v[rows]),
    )
    panels = []
    for law in LAWS:
        for label, x in planes:
            dots = (
                Points(x, case.force[rows], "measured", MEASURED, 3.0, 0.6),
                Points(x, case.forces[law][rows], NAMES[law], COLOURS[law], 3.0, 0.6),
            )
            panels.append(Panel(dots, Axis(label), Axis("force [N]", ends)))
    alt = "Force over deflection and velocity, measured and by each model."
    return Figure(name, alt, tuple(panels), 2, height=height)
