"""What the channels of a record allow: the force of the damper, the motion of the car, or neither."""

from __future__ import annotations

from collections.abc import Iterator

from er_records.record import Record

from er_model_lab.preflight.finding import Finding, Level

MOTION = ("deflection", "deflection_velocity")
OUTPUTS = (
    "damper_force", "sprung_acceleration", "unsprung_acceleration", *MOTION, "sprung_displacement",
    "unsprung_displacement",
)  # fmt: skip
"""What the level of the vehicle can be held against."""


def for_damper(record: Record) -> bool:
    """Whether the force can be predicted from the motion and held against a measured one."""
    return record.has("damper_force") and any(record.has(c) for c in MOTION)


def for_vehicle(record: Record) -> bool:
    """Whether the car can be simulated and held against something."""
    return record.has("road") and any(map(record.has, OUTPUTS))


def use_findings(record: Record) -> Iterator[Finding]:
    """Which level the channels rule out: a warning, or a failure where no level is left."""
    if for_damper(record):
        return
    other = for_vehicle(record)
    level: Level = "warning" if other else "fail"
    lacking = "" if record.has("damper_force") else "damper_force"
    if not any(map(record.has, MOTION)):
        lacking = "deflection"
    yield Finding(
        "channels", level, record.name, lacking, "damper_force, and deflection or deflection_velocity",
        f"only {', '.join(record.channels) or 'the time'}",
        "use level='vehicle'" if other else "record them, or the road for level='vehicle'", record.source,
    )  # fmt: skip
