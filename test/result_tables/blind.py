"""Scores of the lab on data of other generators: the tables that each command wrote."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from test.blind_score.rows import DECIDES
from test.blind_score.tables import table
from test.result_tables.stored import Run


def _run(name: str, command: str, *tables: str, truth: str = "test/blind") -> Run:
    """A run that writes these tables first."""

    def keeps(written: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
        return dict(zip(tables, written, strict=False))

    code = (*DECIDES[:2], truth)
    return Run(name, f"exec python -m test.{command}", "blind.md", code, keeps, "--table FILE")


def noted(name: str, values: Mapping[str, Any]) -> str:
    """A table as the command wrote it."""
    return table(values[name]["head"], values[name]["rows"])


_SCORE = _run("blind_score", "blind_score --seeds 53-62 --records 1 --seconds 60", "blind score")
_LIMIT = _run("blind_limit", "blind_score.limit --seeds 58 61-63", "blind limit")
_ALARMS = _run("blind_alarms", "blind_score.alarms --seeds 1-100", "blind alarms")
_CONDITIONS = _run(
    "blind_conditions",
    "blind_score --condition all --seeds 103 --effects none stribeck_friction rise_fall_asymmetry self_heating",
    "blind conditions",
    "blind conditions missed",
)
_ROUGH = _run(
    "rough_score",
    "rough_score --seeds 91 --cases 100 --workers 2",
    "rough score",
    "rough groups",
    truth="test/rough",
)
TABLES: dict[str, tuple[Run, Callable[[Any], str]]] = {
    name: (run, partial(noted, name))
    for run, names in (
        (_SCORE, ("blind score",)),
        (_LIMIT, ("blind limit",)),
        (_ALARMS, ("blind alarms",)),
        (_CONDITIONS, ("blind conditions", "blind conditions missed")),
        (_ROUGH, ("rough score", "rough groups")),
    )
    for name in names
}
