"""How often the monitor's test calls in vain, and how soon it finds a change."""

from __future__ import annotations

from typing import Any

from er_studies.given_out import table

from test.result_tables.given import Tables, given
from test.result_tables.stored import Run

CODE = ("src/er_model_lab/er_model_lab/monitor",)
ALARMS = Run("alarms", "study alarms", "page.md", CODE)
MEASURED = "study monitor mts/train --model better.yaml"


def false_alarms(values: dict[str, Any]) -> str:
    """Each kind of error by itself."""
    hours = f"false alarms in {values['hours']:g} h"
    head = ["error", hours, "growth by 30 % is found after: median", "95 %"]
    rows = [
        [name, f"{kind['alarms']:g}", f"{kind['median']:.1f} s", f"{kind['late']:.1f} s"]
        for name, kind in values["kinds"].items()
    ]
    return table(head, rows)


TABLES: Tables = {
    "alarms": (ALARMS, false_alarms),
    **given("monitored", MEASURED, "page.md", CODE, "monitor on measured runs"),
}
