"""What stands beside every figure of speed: the machine, by two reference loops."""

from __future__ import annotations

import os
import platform
from collections.abc import Callable
from functools import partial

from er_studies.bench.models.c_reference import c_predict, compiler
from er_studies.bench.models.cases import damper, drive
from er_studies.bench.models.timing import best, shown
from er_studies.given_out import Table

RECORD, ADDITIONS = 60.0, 1_000_000


def machine() -> Table:
    """Cores, Python and load; processor time of the loop of a prediction in C and of a million additions in Python."""
    runs: dict[str, Callable[[], object]] = {"Python": _add}
    if compiler():
        runs["C"] = partial(c_predict, damper(), drive(RECORD))
    found = {name: shown(seconds) for name, seconds in best(runs, 1.0).items()}
    load = f"load average {os.getloadavg()[0]:.1f}"
    cores = f"{os.cpu_count()} cores, Python {platform.python_version()}, {load}"
    head = ("machine", "reference loop in C", "in Python")
    return Table(head, [(cores, found.get("C", "no compiler"), found["Python"])])


def _add() -> None:
    total = 0
    for k in range(ADDITIONS):
        total += k
