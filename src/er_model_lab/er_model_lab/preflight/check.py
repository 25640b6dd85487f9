"""All checks of a data set together, and the gate that stops a command."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Literal

from er_models.catalogue import CATALOGUE, Catalogue
from er_models.errors import InputError
from er_models.model import Model
from er_records.record import Record

from er_model_lab.preflight import excitation, kinematics, samples
from er_model_lab.preflight.between import between_findings
from er_model_lab.preflight.finding import ORDER, Finding
from er_model_lab.preflight.motion import motion_findings
from er_model_lab.preflight.occupancy import CoverMap, maps
from er_model_lab.preflight.rate import at_needed_rate
from er_model_lab.preflight.size import size_findings
from er_model_lab.preflight.usable_channels import use_findings
from er_model_lab.preflight.wild import bridged, marked, wild_findings

Verdict = Literal["usable", "not_usable"]


@dataclass(frozen=True)
class Preflight:
    """What was found in all records, worst first, and what the data cover.

    have: how much there is of each region; missing: effect to the regions it lacks.
    """

    findings: tuple[Finding, ...]
    reach: excitation.Reach
    have: dict[str, float]
    missing: dict[str, tuple[str, ...]]
    maps: tuple[CoverMap, ...]

    @property
    def failures(self) -> tuple[Finding, ...]:
        """What stops a command."""
        return tuple(f for f in self.findings if f.level == "fail")

    @property
    def verdict(self) -> Verdict:
        """In one word."""
        return "usable" if self.passed else "not_usable"

    @property
    def passed(self) -> bool:
        """Whether nothing stops a command."""
        return not self.failures

    def counted(self, level: str) -> int:
        """How many findings there are of a level."""
        return sum(f.level == level for f in self.findings)

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "passed": self.passed,
            "findings": [f.as_json() for f in self.findings],
            "reach": {
                "deflection": self.reach.deflection, "velocity": self.reach.velocity, "duty": self.reach.duty,
                "known_from": self.reach.known_from,
            },
            "cells": [
                {
                    "name": name, "region": cell.text, "need": cell.need, "unit": cell.unit, "have": self.have[name],
                    "covered": self.have[name] >= cell.need,
                    "effects": sorted(e for e, lack in self.missing.items() if name in lack),
                }
                for name, cell in excitation.CELLS.items()
            ],
            "missing": {effect: list(lack) for effect, lack in self.missing.items()},
            "maps": [m.as_json() for m in self.maps],
        }  # fmt: skip


@lru_cache(maxsize=4)
def findings(record: Record) -> tuple[Finding, ...]:
    """Everything that is checked of one record; a check that finds nothing says so once.

    Of the last records it is kept: every verb asks for it.
    """
    record = marked(record)
    whole, record = record, bridged(record)
    known = kinematics.pairs(record)
    found = [
        *samples.time_findings(record),
        *samples.wait_findings(record),
        *samples.held_findings(whole),
        *samples.clipping_findings(whole),
        *wild_findings(whole),
        *kinematics.unit_findings(record, known),
        *kinematics.unchecked_findings(record, known),
        *kinematics.clock_findings(record, known),
        *kinematics.gravity_findings(record),
        *kinematics.power_findings(record),
        *kinematics.actuator_findings(record),
        *kinematics.road_findings(record),
    ]
    checks = {"held": "no repeats", "clipping": "no flat tops"}
    said = {f.check for f in found}
    found += [
        Finding(check, "ok", record.name, "", words, words)
        for check, words in checks.items()
        if check not in said
    ]
    return tuple(found if {"units", "clock"} & said else [*found, *kinematics.fine(record, known)])


def preflight(
    records: Sequence[Record],
    model: Model | None = None,
    catalogue: Catalogue = CATALOGUE,
    *,
    levels: bool = False,
) -> Preflight:
    """Check records; with a model, coverage is measured against the reach of its rig.

    levels: also say which level of the lab the channels allow, before one was chosen.
    """
    found = [f for record in records for f in findings(record)]
    if levels:
        found += [f for record in records for f in use_findings(record)]
    found += motion_findings(records)
    found += between_findings(records)
    found += size_findings(records, model) if model is not None else ()
    courses = [excitation.course_of(bridged(r)) for r in records]
    reach = reach_for(model, excitation.reach_of(courses))
    have = excitation.counts(courses, reach)
    return Preflight(
        tuple(sorted(found, key=lambda f: ORDER[f.level])), reach, have,
        excitation.missing(catalogue, have), maps(courses, reach),
    )  # fmt: skip


def reach_for(model: Model | None, seen: excitation.Reach) -> excitation.Reach:
    """Reach of the model's rig where it says one, else of the data."""
    rig = {} if model is None else model.rig
    known = {
        "deflection": rig.get("stroke"), "velocity": rig.get("velocity_max"), "duty": rig.get("duty_max"),
    }  # fmt: skip
    given = {k: float(v) for k, v in known.items() if v is not None}
    return replace(seen, **given, known_from="the model's rig") if given else seen  # type: ignore[arg-type]


def admitted(
    records: Sequence[Record],
    model: Model | None = None,
    catalogue: Catalogue = CATALOGUE,
    *,
    anyway: bool,
) -> tuple[Preflight, list[Record]]:
    """What the preflight finds, and the records that every verb works on: wild samples marked, at the rate they need.

    Raises:
        InputError: The first failure, with what to do, unless the user wants to go on (`anyway`).
    """
    looked_at = [marked(record) for record in records]
    found = preflight(looked_at, model, catalogue)
    return found, [at_needed_rate(r) for r in gate(found, looked_at, anyway=anyway)]


def gate(found: Preflight, records: Sequence[Record], *, anyway: bool) -> list[Record]:
    """The records when nothing is wrong with them; marked incomplete, with notes, when the user wants to go on.

    Raises:
        InputError: The first failure, with what to do.
    """
    failures = found.failures
    if failures and not anyway:
        f = failures[0]
        others = sum(each.record == f.record for each in failures) - 1
        more = f" (and {others} more; lab check)" if others else ""
        where = f"{f.source}: {f.channel}" if f.channel else f.source
        raise InputError(
            where, f.check, f.expected, f"{f.found}{more}; {f.remedy}; anyway=True goes on"
        )
    return [
        _marked(record, [f for f in failures if f.record == record.name]) for record in records
    ]


def _marked(record: Record, failures: Sequence[Finding]) -> Record:
    """A record with what is wrong with it in its notes."""
    notes = [f"{f.channel}: expected {f.expected}, found {f.found}" for f in failures]
    return replace(record, complete=False).noted(*notes) if failures else record
