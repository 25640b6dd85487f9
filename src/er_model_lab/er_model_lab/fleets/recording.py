"""One recording by itself: can it be used, how far does the model miss it, which values does it give?"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from er_models.errors import ErError, InputError, MissingChannel
from er_models.model import Model
from er_records.dataset import Dataset
from er_records.load import load
from er_records.provenance import content_digest
from er_records.record import Record

from er_model_lab.diagnosis.candidates import baseline
from er_model_lab.fitting.deviations import with_deviations
from er_model_lab.fitting.fit import Fit
from er_model_lab.fitting.velocity_channel import as_searched
from er_model_lab.fleets.asked import Asked
from er_model_lab.fleets.places import content, local
from er_model_lab.problem.problem import Problem
from er_model_lab.residual.errors import errors
from er_model_lab.results.values import clean, parameters
from er_model_lab.verbs.asking import question

SINCE_1970 = 1e8
"""First stamp [s] from which a clock counts from 1970, and so orders recordings among one another."""


@dataclass(frozen=True)
class RecordingJob:
    """A recording to look at; known: the content [SHA-256] for which the answer is kept already, or ""."""

    path: str
    unit: str
    known: str = ""


def recording(job: RecordingJob, asked: Asked) -> dict[str, Any]:
    """The content of a recording, and one row for each record in it; no rows where the answer is kept already.

    Raises:
        ErError: It cannot be read here: a package is missing, or it is `Unreachable` now.
    """
    with local(job.path) as place:
        digest = content(place)
        if digest == job.known:
            return {"content": digest, "rows": None}
        try:
            records = load([place])
        except (InputError, MissingChannel) as error:  # of its content
            said = _one_line(error).replace(str(place), job.path)
            return {
                "content": digest,
                "rows": [{"record": "", "status": "unreadable", "error": said}],
            }
        return {"content": digest, "rows": [_row(r, place, asked) for r in records]}


def _row(record: Record, place: Path, asked: Asked) -> dict[str, Any]:
    """What one record holds and shows."""
    start = float(record.t[0])
    row: dict[str, Any] = {
        "record": record.name, "digest": content_digest(record), "samples": len(record),
        "seconds": len(record) * record.dt, "rate": 1.0 / record.dt, "complete": record.complete,
        "start": start if start > SINCE_1970 else None, "notes": list(record.notes),
    }  # fmt: skip
    if asked.by_namespace:
        row["unit"] = record.name.removeprefix(place.stem).strip("/") or place.parent.name
    try:
        row |= {"status": "used"} | _judged(record, asked)
    except ErError as error:
        row |= {"status": "not_usable", "error": _one_line(error)}
    found: dict[str, Any] = clean(row)
    return found


def _judged(record: Record, asked: Asked) -> dict[str, Any]:
    """Errors of the model as given and refitted [N], the values of the refit, and what is covered."""
    found = question(Dataset.of([record]), asked.model, anyway=asked.anyway)
    opened = found.level.given(found)
    problem, fitted = opened.problem, baseline(opened.searched, opened.problem).fit
    model = _no_surer(
        with_deviations(replace(fitted, model=as_searched(fitted)), problem), fitted, problem
    )
    given, left = (errors(problem, e, problem.used) for e in (opened.given, fitted.residual))
    reach = found.preflight.reach
    return {
        "rmse": given.rmse, "nrmse": given.nrmse, "rmse_refitted": left.rmse,
        "independent": _independent(fitted.residual[problem.used]),
        "velocity": reach.velocity, "deflection": reach.deflection, "duty": reach.duty,
        "values": {
            f"{effect}.{name}": triple
            for effect in model.effects for name, triple in parameters(model, effect).items()
        },
    }  # fmt: skip


def _no_surer(model: Model, fitted: Fit, problem: Problem) -> Model:
    """The model with deviations no smaller than if all other parameters were known.

    Of a parameter that moves the force nowhere a generalised inverse makes a deviation of nearly zero.
    """
    e, j = fitted.residual[problem.train], fitted.jacobian[problem.train]
    length = np.sqrt(np.sum(j**2, axis=0))
    rms = float(np.sqrt(np.mean(e**2)))
    least = np.divide(
        rms * fitted.scale, length, out=np.full(length.size, np.inf), where=length > 0.0
    )
    deviations = {k: dict(v) for k, v in model.deviations.items()}
    for (effect, name), sd in zip(fitted.free, least, strict=True):
        if name in deviations.get(effect, {}):
            deviations[effect][name] = max(deviations[effect][name], float(sd))
    return replace(model, deviations=deviations)


def _independent(e: np.ndarray[Any, np.dtype[np.float64]]) -> float:
    """How many of the samples left (n,) count as independent: by the correlation of neighbours."""
    e = e - e.mean()
    square = float(e @ e)
    r = max(float(e[1:] @ e[:-1]) / square, 0.0) if square > 0.0 else 0.0
    return max(e.size * (1.0 - r) / (1.0 + r), 2.0)


def _one_line(error: ErError) -> str:
    """An error in one line."""
    return " ".join(str(error).split())
