"""Records of one data set whose duty is known and others whose duty is not: what the field did there, nobody knows."""

from __future__ import annotations

from dataclasses import replace

from er_models.errors import MissingChannel

from er_records.dataset import Dataset


def driven(data: Dataset) -> Dataset:
    """The data without records that lack a duty where others are driven.

    A record without duty is one without field where none has a duty. Beside driven ones its duty is more likely lost,
    and a duty of 0 would be learnt as an error of the model. What is left out is noted, and the data are incomplete.

    Raises:
        MissingChannel: No record with a duty is left to learn from, or to score.
    """
    moved = any(r.has("duty") and float(r.channels["duty"].max()) > 0.0 for r in data.records)
    lacking = [r for r in data.records if not r.has("duty")]
    if not moved or not lacking:
        return data
    learn, score = ([r for r in part if r.has("duty")] for part in (data.learn, data.score))
    if not learn or (data.score and not score):
        r = lacking[0]
        why = "since others are driven (a column of zeros says that the field was off)"
        raise MissingChannel(r.source or r.name, "duty", why, tuple(r.channels), r.cure)
    names = ", ".join(r.name for r in lacking)
    note = (
        f"{names}: left out, as the duty is missing and others are driven (a column of zeros says that the field "
        "was off)"
    )
    first, *rest = learn
    return Dataset.of([replace(first, complete=False).noted(note), *rest], score)
