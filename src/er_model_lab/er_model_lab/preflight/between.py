"""Whether the records of a data set are of one damper as it was: the same force at the same motion."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from er_records.record import Record

from er_model_lab.motion.unlike_records import REMEDY, Course, unlike
from er_model_lab.preflight.finding import Finding

NEEDED = ("deflection", "deflection_velocity", "damper_force")


def between_findings(records: Sequence[Record]) -> Iterator[Finding]:
    """A warning where the force of two records differs at the same motion."""
    known = [r for r in records if all(map(r.has, NEEDED))]
    found = unlike([_course(r) for r in known])
    if found:
        yield Finding(
            "records", "warning", found.name, "damper_force", "the same force at the same motion in all records",
            str(found), REMEDY, next(r.source for r in known if r.name == found.name),
        )  # fmt: skip


def _course(record: Record) -> Course:
    """What a record drives and feels; a duty that is not known is 0."""
    x, v, force = (record.channels[c] for c in NEEDED)
    duty = record.channels["duty"] if record.has("duty") else np.zeros(len(record))
    return Course(record.name, x, v, duty, force)
