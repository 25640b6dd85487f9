"""The tables: which stored run each is made of, and how."""

from __future__ import annotations

from test.result_tables import (
    blind,
    control,
    faults,
    fleet,
    identify,
    measured,
    monitor,
    observers,
    reliability,
    speed,
    thesis,
)
from test.result_tables.given import Tables

GROUPS = (
    blind, control, faults, fleet, identify, measured, monitor, observers, reliability, speed, thesis,
)  # fmt: skip
TABLES: Tables = {name: made for group in GROUPS for name, made in group.TABLES.items()}
RUNS = {run.name: run for run, _ in TABLES.values()}
