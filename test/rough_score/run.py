"""One rough case: make it, let the lab improve its start model, and hold the result against a fresh record."""

from __future__ import annotations

import inspect
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

from er_model_lab.results.result import DiagnosisResult
from er_model_lab.verbs.improve import improve
from er_model_lab.verbs.load import load
from er_model_lab.work import Cancelled
from er_models.catalogue import CATALOGUE
from er_models.errors import InputError
from er_models.files import load_model
from er_models.model import Model
from er_records.dataset import Dataset

from test.blind_score.answer import said, timed
from test.blind_score.fused import errors_on
from test.rough.case import Case, RoughError, along, left, make_case, truth_of
from test.rough.plan import Asked

LIMIT = 120.0
"""Processor time for one case [s]: whoever needs longer has failed, on an idle machine and on a busy one."""


def options(measured_terms: bool) -> dict[str, Any]:
    """Arguments of `improve` that were asked for.

    Raises:
        InputError: this lab has no measured terms.
    """
    if not measured_terms:
        return {}
    if "measured_terms" not in inspect.signature(improve).parameters:
        raise InputError(
            "--measured-terms", "", "a lab whose improve has measured terms", "one that has none"
        )
    return {"measured_terms": True}


def score(asked: Asked, *, measured_terms: bool = False, limit: float = LIMIT) -> dict[str, Any]:
    """One row: what was hidden, what was said, and how far the error fell."""
    row: dict[str, Any] = {
        "key": asked.key,
        "kind": asked.kind,
        "seed": asked.seed,
        "measured_terms": measured_terms,
    }
    with tempfile.TemporaryDirectory() as place:
        try:
            case = make_case(asked, Path(place) / "case")
        except RoughError as error:
            return row | {"unmade": str(error)}
        row |= truth_of(case) | {
            "known": [e.name for e in CATALOGUE],
            "names": [],
            "alternatives": [],
            "verdict": "",
        }
        return row | timed(lambda: answer(case, measured_terms, limit))


def watch(limit: float, cancel: threading.Event, done: threading.Event) -> None:
    """Cancel what this process does once it has used so much processor time [s], unless it is done before."""
    end = time.process_time() + limit
    while not done.wait(0.2):
        if time.process_time() > end:
            cancel.set()
            return


def improved(
    data: Dataset, folder: Path, seed: int, limit: float, **asked: Any
) -> DiagnosisResult | None:
    """What `improve` makes of the start model of a case's folder; None: not within so much processor time [s]."""
    cancel, done = threading.Event(), threading.Event()
    threading.Thread(target=watch, args=(limit, cancel, done), daemon=True).start()
    try:
        found = improve(data, load_model(folder / "model.yaml"), seed=seed, cancel=cancel, **asked)
    except Cancelled:
        return None
    finally:
        done.set()
    return None if cancel.is_set() else found


def answer(case: Case, measured_terms: bool, limit: float) -> dict[str, Any]:
    """The lab's answer, and the errors of its model on the fresh record."""
    asked = options(measured_terms)
    found = improved(load(case.data), case.folder, case.asked.seed, limit, **asked)
    if found is None:
        return {"failed": f"no answer within {limit:g} s of processor time"}
    result = found.to_dict()
    out = said(result) | {"outliers": result.get("outliers"), "notes": result["notes"]}
    return out | ({"fresh": fresh(case, found.model)} if found.model is not None else {})


def fresh(case: Case, model: Model) -> dict[str, float | bool]:
    """Errors [N] on the fresh record, as of `errors_on`; filtered: the truth's along a plainly filtered motion."""
    rig, drive, columns = case.rig, case.drives[-1], case.clean[-1]
    errors = errors_on(
        case.fresh,
        model,
        lambda record, t, motion: along(rig, case.laws, drive, t, motion),
        [(columns["t"], columns["damper_force"])],
    )
    return errors | {"filtered": left(rig, drive, case.laws, columns, case.noisy[-1])}
