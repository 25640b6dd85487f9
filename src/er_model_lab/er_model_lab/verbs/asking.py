"""What every verb is asked: from the user's data, model and wishes to a question that the lab can work on."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from er_common.command_line import command_line
from er_common.versions import versions
from er_models.model import Model
from er_records.copies import check_apart
from er_records.dataset import Dataset
from er_records.load import fingerprint, told_apart

from er_model_lab.diagnosis.rule import RULE, Rule
from er_model_lab.level.investigate import level_of
from er_model_lab.level.level import Question
from er_model_lab.preflight.check import admitted
from er_model_lab.problem.stretches import shortened
from er_model_lab.work import HERE, Work


def question(
    data: Dataset,
    model: Model,
    *,
    held_out: Dataset | None = None,
    level: str = "damper",
    seed: int = 0,
    rule: Rule = RULE,
    anyway: bool = False,
    work: Work = HERE,
) -> Question:
    """The question, on data that passed the preflight; of data too long to be searched whole, on stretches of them.

    held_out: data that only score; anyway: data that fail the preflight are used all the same.

    Raises:
        InputError: data that fail it, that are learnt from and score, or a level that there is none of.
        MissingChannel: a channel that the level needs.
    """
    chosen = level_of(level)
    scored = () if held_out is None else held_out.records
    both = Dataset.of(data.learn, (*data.score, *scored))
    check_apart(both)
    apart = told_apart(list(both.records))
    found, records = admitted(apart, model, model.catalogue, anyway=anyway)
    passed = both.with_records(records)
    return Question(shortened(chosen.usable(passed)), model, chosen, found, seed, rule, work)


def provenance(data: Dataset, model: Model, seed: int) -> dict[str, Any]:
    """Where a result comes from: data, model, seed and versions."""
    records = data.originals
    return {
        "data": fingerprint(records), "records": [r.name for r in records], "model_file": model.file,
        "model": model.digest(), "seed": seed, "versions": versions(), "command_line": command_line(),
        "effects_from": {name: asdict(o) for name, o in model.catalogue.origins.items()},
    }  # fmt: skip
