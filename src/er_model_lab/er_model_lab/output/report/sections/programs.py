"""Planned programs: how they separate, what they drive, and the forces of each truth with its best imitation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from er_model_lab.output.report.figure import Axis, Band, Figure, Line, Mark, Panel
from er_model_lab.output.report.palette import AFTER, BEFORE, FLOOR, MEASURED
from er_model_lab.output.report.section import Section
from er_model_lab.output.text.units import short
from er_model_lab.view import ImitationView, ProgramView, View

SHOWN = 12.0
"""Seconds of a program that are seen first, at most."""


def section(view: View) -> Section | None:
    """The table of programs and their pictures; None where nothing was planned."""
    if "programs" not in view.result:
        return None
    result = view.result
    rows = [row(result, r) for r in (*result["programs"], result["identification"]) if r]
    figures = [f for k, p in enumerate(view.programs) for f in _figures(p, first=k == 0)]
    text = [*result["why"][1:], *(f"Program: {f}" for f in [result.get("program_file")] if f)]
    facts = {"text": text, "head": head(result), "rows": rows}
    return Section("programs", "Programs", tuple(figures), facts, template="prose")


def head(result: Mapping[str, Any]) -> list[str]:
    """Names of the columns of the table of programs."""
    apart = [f"if {name}" for name in _names(result)]
    return ["program", *apart, "stroke [mm]", "velocity [m/s]", "duty", "named rightly"]


def row(result: Mapping[str, Any], program: Mapping[str, Any]) -> list[str]:
    """One program as a row of that table: separations over the noise, peaks, decisions of the lab."""
    used = program["used"]
    apart = [short(program["separation"][name], 2) for name in _names(result)]
    peaks = [short(1e3 * used["stroke"], 3), short(used["velocity"], 3), short(used["duty"], 2)]
    return [str(program["name"]), *apart, *peaks, _named(result, program)]


def _names(result: Mapping[str, Any]) -> list[str]:
    """The effects that may be true."""
    return list(result.get("between") or [result["reveal"]])


def _named(result: Mapping[str, Any], program: Mapping[str, Any]) -> str:
    """How often simulated measurements named the truth; empty where none were made."""
    everyday = result["identification"]
    if program is everyday or (everyday and program["name"] == everyday["name"]):
        found = result["measurements_identification"]
    elif program["name"] == result["programs"][0]["name"]:
        found = result["measurements"]
    else:
        return ""
    return f"{sum(m['right'] for m in found.values())} of {sum(m['runs'] for m in found.values())}"


def _figures(program: ProgramView, *, first: bool) -> list[Figure]:
    """What the program drives, and what forces that makes."""
    key = "planned" if first else "everyday"
    span = (0.0, min(SHOWN, program.cycle, float(program.t[-1])))
    return [_driven(program, key, span), _forces(program, key, span)]


def _driven(program: ProgramView, key: str, span: tuple[float, float]) -> Figure:
    """Road, deflection and duty over time."""
    x = Axis(span=span)
    panels = (
        Panel((_curve(program, 1e3 * program.road, "road", MEASURED),), x, Axis("road [mm]"), program.name),
        Panel((_curve(program, 1e3 * program.deflection, "deflection", AFTER),), x, Axis("deflection [mm]")),
        Panel((_curve(program, program.duty, "duty", BEFORE),), Axis("time [s]", span), Axis("duty")),
    )  # fmt: skip
    alt = f"Road, deflection and duty of {program.name} over time."
    return Figure(f"{key}_program", alt, panels, height=460, linked=True)


def _forces(program: ProgramView, key: str, span: tuple[float, float]) -> Figure:
    """For each truth its force, the best imitation, and their difference with the noise."""
    panels: list[Panel] = []
    for k, found in enumerate(program.imitations):
        last = k == len(program.imitations) - 1
        panels += _pair(program, found, span, last=last)
    alt = f"Forces along {program.name}: each effect, its best imitation, and what the imitation leaves."
    heights = (2.0, 1.5) * len(program.imitations)
    return Figure(f"{key}_forces", alt, tuple(panels), height=320 * len(program.imitations) + 60,
                  heights=heights, linked=True)  # fmt: skip


def _pair(
    program: ProgramView, found: ImitationView, span: tuple[float, float], *, last: bool
) -> list[Panel]:
    """Two panels: the forces, and their difference."""
    noise = Band(-1.96 * found.floor, 1.96 * found.floor, "noise, 95 %", FLOOR)
    forces: tuple[Mark, ...] = (
        _curve(program, found.force, "truth", MEASURED),
        _curve(program, found.imitated, "best imitation", BEFORE),
    )
    difference = _curve(program, found.force - found.imitated, "difference", AFTER)
    name = f"{found.truth}, imitated by {found.imitation}"
    return [
        Panel(forces, Axis(span=span), Axis("force [N]"), name),
        Panel((noise, difference), Axis("time [s]" if last else "", span), Axis("difference [N]")),
    ]


def _curve(program: ProgramView, y: Any, name: str, colour: str) -> Line:
    """A curve over the program's time."""
    return Line(program.t, y, name, colour, 1.1)
