"""The tables: which stored run each is made of, and how."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from test.result_tables import (
    blind,
    control,
    fleet,
    identify,
    measured,
    monitor,
    observers,
    thesis,
)
from test.result_tables.stored import Run

TABLES: dict[str, tuple[Run, Callable[[Any], str]]] = {
    name: made
    for group in (blind, control, fleet, identify, measured, monitor, observers, thesis)
    for name, made in group.TABLES.items()
}
RUNS = {run.name: run for run, _ in TABLES.values()}
