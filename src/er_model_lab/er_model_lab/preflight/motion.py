"""Whether the motion of all records together is more than a curve or two that are run through again and again."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from er_records.record import Record

from er_model_lab.motion.repetition import FEW_CURVES, REMEDY, curves, cycles, one_curve
from er_model_lab.preflight.finding import Finding


def motion_findings(records: Sequence[Record]) -> Iterator[Finding]:
    """A warning where the motion repeats itself and cannot tell effects apart."""
    known = [r for r in records if r.has("deflection_velocity")]
    if len(known) < len(records) or not known or len({r.dt for r in known}) > 1:
        return
    parts = [r.channels["deflection_velocity"] for r in known]
    velocity = np.concatenate(parts)
    rows = list(pairwise([0, *np.cumsum([p.size for p in parts]).tolist()]))
    found = cycles(velocity, known[0].dt, rows)
    if not 0 < curves(found, velocity, rows) <= FEW_CURVES:
        return
    yield Finding(
        "motion", "warning", known[0].name, "deflection_velocity", "a motion of several frequencies or sizes",
        one_curve(found[0].frequency), f"{REMEDY} (lab plan)", known[0].source,
    )  # fmt: skip
