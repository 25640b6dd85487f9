"""Refit a model, then say which effect it lacks, with evidence."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import replace

from er_models.model import Model
from er_records.dataset import Dataset

from er_model_lab.blas import on_one_thread
from er_model_lab.diagnosis.rule import RULE, Rule
from er_model_lab.fitting.rig import rig_note
from er_model_lab.level.investigate import investigate
from er_model_lab.level.level import Question
from er_model_lab.level.study import Study
from er_model_lab.planning.suggest import suggestions
from er_model_lab.residual.errors import regions_json, worst
from er_model_lab.results.by_record import by_record, with_flags
from er_model_lab.results.diagnosis import diagnosis_json
from er_model_lab.results.draw import study_regions, study_view
from er_model_lab.results.result import DiagnosisResult
from er_model_lab.results.values import clean
from er_model_lab.verbs.asking import provenance, question
from er_model_lab.work import Event, Progress, Work

OFFER = (
    "what is left may be learnt as one smooth term, measured and not explained, with its shape: "
    "improve with measured_terms=True"
)
"""Note on a verdict that leaves something no known effect explains."""


@on_one_thread
def diagnose(
    data: Dataset,
    model: Model,
    *,
    held_out: Dataset | None = None,
    level: str = "damper",
    seed: int = 0,
    rule: Rule = RULE,
    anyway: bool = False,
    progress: Progress | None = None,
    cancel: Event | None = None,
    executor: Executor | None = None,
) -> DiagnosisResult:
    """Refit the model, then say which effect is missing."""
    asked = question(
        data,
        model,
        held_out=held_out,
        level=level,
        seed=seed,
        rule=rule,
        anyway=anyway,
        work=Work.by(executor, progress, cancel),
    )
    study = investigate(asked)
    asked.work.wind_up()
    result = result_of("diagnose", study, asked.level.finished(study, seed), asked)
    return with_flags(result, last=offer(result, asked))


def offer(result: DiagnosisResult, asked: Question) -> tuple[str, ...]:
    """The offer of a measured term, where something is left that no effect explains."""
    last = result.view.result.get("final_verdict", result.verdict)
    of_use = asked.level.name == "damper" and last in ("unknown_effect", "partial")
    return (OFFER,) if of_use and not asked.model.terms and not result.interrupted else ()


def result_of(command: str, study: Study, model: Model, asked: Question) -> DiagnosisResult:
    """The result of a study; model: the best one, with estimates."""
    origin = provenance(study.data, study.model, asked.seed)
    found = study.diagnosis
    shown = [found.base] if found.best is found.base else [found.base, found.best]
    tables, *more = study_regions(study, asked.seed, *(each.fit.residual for each in shown))
    later = more[0] if more else ()
    content = {
        "command": command,
        **diagnosis_json(study, model),
        **asked.level.particulars(study),
        "by_record": by_record(study.diagnosis, study.problem, study.data),
        "history": [dict(h) for h in model.history],
        "regions": regions_json(tables),
        "worst": worst(tables),
        "worst_after": worst(later) if more else [],
        "preflight": asked.preflight.as_json(),
        "provenance": origin,
    }
    if study.checked is not None:
        content["long"] = study.checked.as_json(again=study.again)
    content["next_plans"] = suggestions(content) if asked.level.name == "damper" else []
    content["notes"] = [*rig_note(model, asked.model), *content["notes"]]
    view = study_view(command, study, clean(content), origin)
    return DiagnosisResult(
        replace(view, regions=tables, regions_after=later),
        model,
        interrupted=study.diagnosis.interrupted,
    )
