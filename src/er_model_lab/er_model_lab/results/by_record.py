"""Leave-one-record-out: how well each record is predicted by what was learnt from the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from er_records.dataset import Dataset
from numpy.typing import NDArray

from er_model_lab.diagnosis.found import Diagnosis
from er_model_lab.diagnosis.rule import BAND
from er_model_lab.fitting.cross_validation import cross_validated
from er_model_lab.problem.problem import Problem
from er_model_lab.results.result import DiagnosisResult, with_notes

FEWEST = 3
"""Records from which on one of them can be left out."""


def by_record(
    found: Diagnosis, problem: Problem, data: Dataset, *, straight: bool = False
) -> list[dict[str, Any]]:
    """Error [N] of each record: before, after, and after with the parameters that the other records give.

    The samples that were held out count as well. `rms_force` is what predicting nothing leaves. Empty for fewer than
    three records. straight: a straight line is enough, as after an interruption, when nobody waits for more.
    """
    place = _record_of(problem, data)
    names, used = data.originals, problem.used
    known = np.unique(place[used])
    if known.size < FEWEST or problem.forward.outputs > 1:
        return []
    fold = np.where(used, np.searchsorted(known, place), -1)
    everything = replace(problem, fold=fold, held_out=np.zeros_like(used))
    quick = straight or found.interrupted
    left_out, _ = cross_validated(found.best.fit, everything, straight=quick)
    left = {
        "rmse_before": found.base.fit.residual, "rmse_after": found.best.fit.residual, "rmse_left_out": left_out,
    }  # fmt: skip
    return [
        {"record": names[r].name, "samples": int(rows.sum())}
        | {"rms_force": float(np.sqrt(np.mean(problem.force[rows] ** 2)))}
        | {key: float(np.sqrt(np.mean(e[rows] ** 2))) for key, e in left.items()}
        for r, rows in ((int(r), used & (place == r)) for r in known)
    ]


def flagged(records: Sequence[dict[str, Any]]) -> tuple[list[dict[str, Any]], list[str]]:
    """Records as `by_record` gives them, each with a flag `worse_than`, and a note on those that have one.

    The flag names what leaves less than the model does: "nothing" (a force of zero), the model "before".
    """
    told = [each | {"worse_than": _worse_than(each)} for each in records]
    return told, [_said(each) for each in told if each["worse_than"]]


def with_flags(result: DiagnosisResult, last: Sequence[str] = ()) -> DiagnosisResult:
    """The result with a flag and a note at each record that the model describes worse than it did, or than nothing.

    last: further notes, behind all others.
    """
    records, notes = flagged(result.view.result["by_record"])
    content = dict(result.view.result) | {"by_record": records}
    return with_notes(
        replace(result, view=replace(result.view, result=content)), *notes, last=last
    )


def _worse_than(each: Mapping[str, Any]) -> list[str]:
    """What leaves less of a record than the model does."""
    limits = {"nothing": each["rms_force"], "before": (1.0 + BAND) * each["rmse_before"]}
    return [name for name, limit in limits.items() if each["rmse_after"] > limit]


def _said(each: Mapping[str, Any]) -> str:
    """A record's flag in words."""
    left = f"record {each['record']}: the model errs by {each['rmse_after']:.3g} N"
    if "nothing" in each["worse_than"]:
        return f"{left}, a force of zero by {each['rms_force']:.3g} N"
    return f"{left}, before by {each['rmse_before']:.3g} N"


def _record_of(problem: Problem, data: Dataset) -> NDArray[np.int64]:
    """Number of the record that each sample (n,) belongs to; stretches of one record are one."""
    sizes = np.diff(problem.motion.starts)
    return np.repeat(np.array(data.numbers, np.int64), sizes * problem.forward.outputs)
