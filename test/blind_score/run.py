"""One case: make it, let the lab improve the model, and note everything that was said."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from er_model_lab.verbs.improve import improve
from er_model_lab.verbs.load import load
from er_models.files import load_model

from test.blind.case import Case, excess_after_refit
from test.blind.errors import BlindError
from test.blind.generator import make_case, more_records
from test.blind_score.answer import said, timed
from test.blind_score.cases import Asked, Layout, layout
from test.blind_score.fresh import fresh_errors
from test.blind_score.rows import ROOT

MODEL = ROOT / "config" / "dampers" / "inove_guo.yaml"
REDRAWS = 5
ANOTHER = 100_000
"""Distance of the seeds of a case that is drawn again, and of fresh records."""


def drawn(asked: Asked, size: Layout, folder: Path) -> tuple[Case, int]:
    """The case, and how often it was drawn again because its effects could not show as they should.

    Raises:
        BlindError: never in so many draws.
    """
    hidden = list(asked.hidden) or None
    for trial in range(REDRAWS):
        seed = asked.seed + ANOTHER * trial
        try:
            case = make_case(
                hidden,
                seed,
                out=folder / f"made_{trial}",
                n_records=size.records,
                seconds=size.seconds,
            )
        except BlindError:
            if trial == REDRAWS - 1:
                raise
        else:
            break
    if asked.program == "rich":
        return case, trial
    poor = more_records(
        case, seed, out=folder / "poor", n_records=size.records, program=asked.program
    )
    return poor, trial


def truth_of(case: Case) -> dict[str, Any]:
    """What was hidden."""
    return {
        "rise": [one.rise for one in case.hidden],
        "rise_together": excess_after_refit(case),
        "truth": {one.effect.name: one.effect.named(one.row) for one in case.hidden},
    }


def score(asked: Asked, size: Layout | None = None) -> dict[str, Any]:
    """One row: what was hidden, what was said, and how far the error fell."""
    size = size or layout(asked.seed)
    row = begun(asked, size)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        case, row["redrawn"] = drawn(asked, size, folder)
        row |= truth_of(case)
        row |= timed(lambda: _answer(asked, case, folder))
    return row


def begun(asked: Asked, size: Layout) -> dict[str, Any]:
    """What is known of a row before the lab is asked."""
    return {
        "key": asked.key, "kind": asked.kind, "hidden": list(asked.hidden), "program": asked.program,
        "seed": asked.seed, "records": size.records, "seconds": size.seconds,
    }  # fmt: skip


def _answer(asked: Asked, case: Case, folder: Path) -> dict[str, Any]:
    """The lab's answer, and its error on fresh records where one effect was hidden."""
    model = load_model(MODEL)
    found = improve(load(case.directory), model, seed=asked.seed)
    answer = {"model": model.digest(), **said(found.to_dict())}
    if asked.kind == "singles" and found.model is not None:
        fresh = more_records(case, case.seed + ANOTHER // 2, out=folder / "fresh", n_records=1)
        answer["fresh"] = fresh_errors(fresh, found.model)
    return answer
