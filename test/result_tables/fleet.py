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


def workers(values: dict[str, Any]) -> str:
    """Times and memory of the loop and of the workers, with what they are held to."""
    head = [
        "200 units",
        "time",
        "processor time",
        "largest worker, first and last third",
        "client",
        "",
    ]
    rows = [
        [
            line["what"], f"{line['wall']:.0f} s", f"{line['processor']:.0f} s",
            f"{line['first']:.0f}, {line['last']:.0f} MB" if line["last"] else "", f"{line['client']:.0f} MB", said,
        ]
        for line, said in zip(values["workers"], _held(*values["workers"]), strict=True)
    ]  # fmt: skip
    return table(head, rows)


def _held(loop: dict[str, Any], one: dict[str, Any], two: dict[str, Any]) -> tuple[str, str, str]:
    """What is said of the loop, of one worker and of two."""
    longer, more = (f"{100.0 * (one[k] / loop[k] - 1.0):+.1f} %" for k in ("wall", "processor"))
    alone = f"{longer} time beside the loop (at most +5 %), {more} processor time"
    return "", alone, f"{one['wall'] / two['wall']:.2f} times faster than one (at least 1.85)"


BENCH = (*SCORE.decides, "src/er_studies/er_studies/bench/fleet")
WORKERS = Run(
    "bench_workers",
    "bench fleet workers",
    "fleet.md",
    BENCH,
    lambda written: {"workers": written["workers"]},
)
TABLES: Tables = {
    "fleet": (SCORE, score),
    "fleet workers": (WORKERS, workers),
    **given(
        "bench_cluster",
        "bench fleet cluster --units 3 --clusters 1000 3000",
        "fleet.md",
        BENCH,
        "fleet cluster",
        writes="> FILE",
    ),
}
