"""How well known dampers come back."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from er_studies.given_out import table

from test.identify_data import TRUTHS
from test.identify_score import HEAD
from test.result_tables.stored import Run

IDENTIFY = Run(
    "identify",
    "exec python -m test.identify_score --seeds 100",
    "identification.md",
    ("src/er_models/er_models", "src/er_records/er_records", "src/er_model_lab/er_model_lab"),
)


def returned(damper: str, values: dict[str, Any]) -> str:
    """The parameters of one damper."""
    return table(HEAD, values[damper])


TABLES: dict[str, tuple[Run, Callable[[Any], str]]] = {
    truth.model: (IDENTIFY, partial(returned, truth.model)) for truth in TRUTHS.values()
}
