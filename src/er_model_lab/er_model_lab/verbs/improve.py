"""`lab improve`: diagnose and add, again and again, until the model is adequate or nothing known helps."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from er_models.files import save_model
from er_models.model import Array, Model

from er_model_lab.blas import on_one_thread
from er_model_lab.diagnosis.by_record import by_record
from er_model_lab.diagnosis.resume import Begun, finished, marked, resume, with_fits
from er_model_lab.diagnosis.study import (
    Study,
    final_model,
    investigate,
)
from er_model_lab.fitting.velocity_channel import as_searched
from er_model_lab.long.check import long_note
from er_model_lab.records.record import Record
from er_model_lab.results.diagnosis import diagnosis_json
from er_model_lab.results.passes import explained_by, taken_last, told_together
from er_model_lab.results.values import clean, headline
from er_model_lab.results.views import candidate_views, views
from er_model_lab.verbs.ask import Outcome, Request, read
from er_model_lab.verbs.diagnose import outcome_of
from er_model_lab.verbs.history import with_history
from er_model_lab.work import HERE, STOPPED, Work

MOST_PASSES = 10
"""How often `improve` diagnoses the model it has just improved."""


@on_one_thread
def improve(ask: Request, out: Path, work: Work = HERE) -> Outcome:
    """Diagnose and add until the model is adequate or nothing known helps; the new model is refitted in any case.

    Ctrl-C ends it with what was done until then, from which the same command goes on later to the same end.
    """
    model, (records, sealed) = ask.model(), read(ask)
    begun = resume(out, model, records, ask.catalogue)
    current, studies, stopped = model, list[Study](), False
    for n in range(MOST_PASSES):
        try:
            study = investigate(
                records, current, seed=ask.seed + 1000 * n, sealed=sealed, rule=ask.rule, work=work, level=ask.level,
                noted=begun.noted,
            )  # fmt: skip
            best = final_model(study, ask.seed)
        except STOPPED:
            if not studies:
                raise
            work.wind_up()
            stopped = True
            break
        studies.append(study)
        records = list(study.records)  # of long data with the stretches where the model did worst
        found = study.diagnosis
        refitted = current is model and (
            found.verdict != "insufficient_data" or not found.coverage.blocking
        )
        if study.diagnosis.effects or refitted:
            current = with_history(best, current, study, records, ask.seed, out)
            current = marked(current, begun.digest)
        stopped = study.diagnosis.interrupted
        if stopped or study.diagnosis.verdict != "partial":
            break
    current = finished(current, interrupted=stopped)
    outcome = gone_on(_improved(studies, current, records, ask), begun, out)
    save_model(with_fits(current, begun.noted) if stopped else current, out)
    return replace(outcome, interrupted=stopped, result=outcome.result | {"interrupted": stopped})


def _improved(studies: list[Study], model: Model, records: list[Record], ask: Request) -> Outcome:
    """The outcome of several passes as one fall of the error."""
    first, last = studies[0], studies[-1]
    outcome = outcome_of("improve", first, model, records, ask)
    results = [outcome.result, *(_later(s, model, records) for s in studies[1:])]
    cards = [outcome.view.candidates]
    cards += [candidate_views(s, r) for s, r in zip(studies[1:], results[1:], strict=True)]
    result = told_together(results)
    view = replace(outcome.view, candidates=taken_last(cards, results))
    if len(studies) > 1:
        result |= explained_by(first.diagnosis, last.diagnosis)
        view = replace(view, headline=headline(result["rmse"]["held_out"], result["noise_floor"]))
        after = last.problem.force - last.diagnosis.best.fit.residual
        view = replace(view, records=views(last.problem, _before(first, last), after))
    if first.long is not None and last.long is not None:
        told, now = long_note(first.long), long_note(last.long)
        result["notes"] = [now if note == told else note for note in result["notes"]]
        view = replace(view, notes=tuple(now if note == told else note for note in view.notes))
    return Outcome(result, replace(view, result=result), model, outcome.complete)


def _before(first: Study, last: Study) -> Array:
    """What the model before all passes predicts of the samples of the last one (n,) [N]."""
    fitted = first.diagnosis.base.fit
    if np.array_equal(first.problem.force, last.problem.force):
        return np.asarray(first.problem.force - fitted.residual)
    return last.problem.predict(as_searched(fitted))


def _later(study: Study, model: Model, records: list[Record]) -> dict[str, Any]:
    """The JSON of a pass after the first."""
    left = by_record(study.diagnosis, study.problem, study.records or records)
    told = diagnosis_json(study, model) | {"by_record": left}
    found: dict[str, Any] = clean(told | ({"long": study.long} if study.long else {}))
    return found


def gone_on(outcome: Outcome, begun: Begun, out: Path) -> Outcome:
    """The outcome with a note where an interruption had left something to go on from."""
    if begun.added is None:
        return outcome
    note = f"went on from {out}, which an interruption had left with {len(begun.added)} done"
    outcome.result["notes"] = [note, *outcome.result["notes"]]
    return replace(outcome, view=replace(outcome.view, notes=(note, *outcome.view.notes)))
