"""Leave-one-record-out: how well each record is predicted by what was learnt from the others."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from er_records.dataset import Dataset
from numpy.typing import NDArray

from er_model_lab.diagnosis.investigation import Diagnosis
from er_model_lab.fitting.fit import cross_validated
from er_model_lab.problem.problem import Problem

FEWEST = 3
"""Records from which on one of them can be left out."""


def by_record(found: Diagnosis, problem: Problem, data: Dataset) -> list[dict[str, Any]]:
    """Error [N] of each record: before, after, and after with the parameters that the other records give.

    The samples that were held out count as well. Empty for fewer than three records.
    """
    place = _record_of(problem, data)
    names, used = data.originals, problem.used
    known = np.unique(place[used])
    if known.size < FEWEST or problem.forward.outputs > 1:
        return []
    fold = np.where(used, np.searchsorted(known, place), -1)
    everything = replace(problem, fold=fold, held_out=np.zeros_like(used))
    left_out, _ = cross_validated(found.best.fit, everything)
    left = {
        "rmse_before": found.base.fit.residual, "rmse_after": found.best.fit.residual, "rmse_left_out": left_out,
    }  # fmt: skip
    return [
        {"record": names[r].name, "samples": int(rows.sum())}
        | {key: float(np.sqrt(np.mean(e[rows] ** 2))) for key, e in left.items()}
        for r, rows in ((int(r), used & (place == r)) for r in known)
    ]


def _record_of(problem: Problem, data: Dataset) -> NDArray[np.int64]:
    """Number of the record that each sample (n,) belongs to; stretches of one record are one."""
    sizes = np.diff(problem.motion.starts)
    return np.repeat(np.array(data.numbers, np.int64), sizes * problem.forward.outputs)
