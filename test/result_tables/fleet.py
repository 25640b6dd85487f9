"""How often units that differ are found in fleets of which everything is known."""

from __future__ import annotations

from typing import Any

from er_studies.given_out import table

from test.fleet_score import TARGETS
from test.result_tables.given import Tables, given
from test.result_tables.stored import Run

SCORE = Run(
    "fleet_score",
    "exec python -m test.fleet_score --fleets 20 --seed 1001",
    "fleet.md",
    ("src/er_model_lab/er_model_lab/fleets",),
)
SAID = {
    "precision": "precision of the named units", "recall": "recall", "false_discoveries": "false discoveries",
    "change_points": "change points within 10 % of the span",
    "cover": "90 % intervals of the pooled parameters that hold the truth",
}  # fmt: skip


def score(values: dict[str, Any]) -> str:
    """Every share beside what it must keep to."""
    counts = {
        "precision": f": {values['right']} right, {values['wrong']} wrong",
        "recall": f": {values['missed']} missed",
    }
    rows = [
        [said, f"{values[name]:.1%}".replace("%", " %") + counts.get(name, ""), _wanted(*TARGETS[name])]
        for name, said in SAID.items()
    ]  # fmt: skip
    return table(["", f"{values['fleets']} fleets", "wanted"], rows)


def _wanted(low: float, high: float) -> str:
    """A range in percent, without the end that no share passes."""
    if high == 1.0:
        return f"at least {100 * low:g} %"
    return f"at most {100 * high:g} %" if low == 0.0 else f"{100 * low:g} to {100 * high:g} %"


TABLES: Tables = {
    "fleet": (SCORE, score),
    **given(
        "bench_cluster",
        "bench fleet cluster --units 3 --clusters 1000 3000",
        "fleet.md",
        (*SCORE.decides, "src/er_studies/er_studies/bench/fleet"),
        "fleet cluster",
        writes="> FILE",
    ),
}
