"""How often the monitor's test calls in vain, and how soon it finds a change."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from er_studies.given_out import table

from test.result_tables.stored import Run

ALARMS = Run("alarms", "study alarms", "page.md", ("src/er_model_lab/er_model_lab/monitor",))


def false_alarms(values: dict[str, Any]) -> str:
    """Each kind of error by itself."""
    hours = f"false alarms in {values['hours']:g} h"
    head = ["error", hours, "growth by 30 % is found after: median", "95 %"]
    rows = [
        [name, f"{kind['alarms']:g}", f"{kind['median']:.1f} s", f"{kind['late']:.1f} s"]
        for name, kind in values["kinds"].items()
    ]
    return table(head, rows)


TABLES: dict[str, tuple[Run, Callable[[Any], str]]] = {"alarms": (ALARMS, false_alarms)}
