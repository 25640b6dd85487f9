"""Cases off the nominal condition: which are asked, one row of each, and the tables.

A wrong certain name is the worst: a name that is not hidden in a verdict that is sure, or any name for a complete
model. What the data cannot decide may stay open: that is no more than modest, and so are the claim that something
unknown remains where nothing is hidden, and data called insufficient.
"""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from er_model_lab.verbs.improve import improve
from er_model_lab.verbs.load import load
from er_models.files import load_model
from er_models.model import Model

from test.blind.case import excess_after_refit
from test.blind_score.answer import said, timed
from test.blind_score.cases import Asked, Layout, few, plan
from test.blind_score.conditions import CONDITIONS, changed_case, given, measured
from test.blind_score.judge import CERTAIN, HONEST, Row, false_names, judged
from test.blind_score.run import MODEL, begun, drawn
from test.blind_score.summary import BEST, table

WORDS = ("right", "modest", "wrong", "failed")


def asked_off(
    names: Sequence[str], seeds: Sequence[int], kinds: Sequence[Any], effects: Sequence[str] | None
) -> list[Asked]:
    """The few cases of every seed under every condition, or those of the kinds and effects asked for."""
    chosen = plan(kinds, seeds, effects) if kinds else [a for s in seeds for a in few(s)]
    if effects and not kinds:
        chosen = [a for a in chosen if set(a.hidden or ("none",)) & set(effects)]
    return [replace(a, condition=name) for name in names for a in chosen]


def score_off(asked: Asked, size: Layout | None = None) -> dict[str, Any]:
    """One row: what was hidden by effect and bench, and what was said."""
    condition = CONDITIONS[asked.condition]
    size = size or condition.size
    hidden = [*asked.hidden, *(e for e in condition.adds if e not in asked.hidden)]
    row = {**begun(asked, size), "hidden": hidden, "condition": asked.condition}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        case, row["redrawn"] = drawn(asked, size, folder)
        case = changed_case(case, condition, asked.seed)
        row["rise_together"] = excess_after_refit(case)
        data = measured(case, condition, asked.seed, folder / "seen")
        model = given(condition, asked.seed, MODEL, folder)
        row |= timed(lambda: _answer(data, load_model(model), asked.seed))
    return row


def _answer(data: Path, model: Model, seed: int) -> dict[str, Any]:
    """The lab's answer."""
    result = improve(load(data), model, seed=seed).to_dict()
    return {"model": model.digest(), "notes": result["notes"], **said(result)}


def worth(row: Row) -> str:
    """right, modest (no certain name that is wrong), wrong, or failed; of data that are wrong it is right to say so."""
    told = CONDITIONS[row["condition"]].told
    if told:
        said_so = told in row.get("failed", " ".join(row.get("notes", [])))
        return "right" if said_so else "wrong"
    if row.get("failed"):
        return "failed"
    sure, false = row["verdict"] == CERTAIN, false_names(row)
    if row["kind"] == "complete":
        if false and (sure or not CONDITIONS[row["condition"]].another_form):
            return "wrong"
        open_ = (*HONEST, "insufficient_data")
        known = set(row["names"]) == set(row["hidden"]) and row["verdict"] not in open_
        return "right" if known else "modest"
    if row["kind"] == "outside":
        return "right" if row["verdict"] in HONEST else "wrong" if false else "modest"
    if sure and false:
        return "wrong"
    best = judged({**row, "kind": "pairs" if len(row["hidden"]) > 1 else "singles"})
    return "right" if best in (BEST["singles"], BEST["pairs"]) and not false else "modest"


def _line(row: Row) -> list[str]:
    """What was said of one row."""
    groups = [" ".join(g) for g in row.get("alternatives", [])]
    return [
        row["key"],
        worth(row),
        row.get("verdict", row.get("failed", "")),
        " ".join(row.get("names", [])) or "-",
        " / ".join(groups) or "-",
        f"{row['rise_together']:.0%}",
    ]


def off_page(rows: Sequence[Row], heading: str) -> str:
    """One line a condition, and every row that is not right."""
    lines = []
    for name in dict.fromkeys(r["condition"] for r in rows):
        group = [r for r in rows if r["condition"] == name]
        count = Counter(worth(r) for r in group)
        lines.append(
            [f"`{name}`", CONDITIONS[name].what, str(len(group)), *(str(count[w]) for w in WORDS)]
        )
    others = [_line(r) for r in rows if worth(r) != "right"]
    head = ["condition", "what differs", "cases", *WORDS]
    rest = ["case", "worth", "verdict", "named", "alternatives", "rise"]
    return f"{heading}\n\n{table(head, lines)}\n## Every row that is not right\n\n{table(rest, others)}"
