"""`lab diagnose`: refit, then say which effect is missing."""

from __future__ import annotations

from dataclasses import replace

from er_models.model import Model

from er_model_lab.blas import on_one_thread
from er_model_lab.diagnosis.by_record import by_record
from er_model_lab.diagnosis.study import (
    Study,
    final_model,
    investigate,
)
from er_model_lab.plan.suggest import suggestions
from er_model_lab.preflight.check import preflight
from er_model_lab.records.record import Record, originals
from er_model_lab.residual.errors import regions_json, worst
from er_model_lab.results.diagnosis import diagnosis_json
from er_model_lab.results.fusion import fusion_json
from er_model_lab.results.values import clean
from er_model_lab.results.views import study_regions, study_view
from er_model_lab.verbs.ask import Outcome, Request, provenance, read
from er_model_lab.work import HERE, Work


@on_one_thread
def diagnose(ask: Request, work: Work = HERE) -> Outcome:
    """Refit, then say which effect is missing."""
    model, (records, sealed) = ask.model(), read(ask)
    study = investigate(
        records, model, seed=ask.seed, sealed=sealed, rule=ask.rule, work=work, level=ask.level
    )
    return outcome_of("diagnose", study, final_model(study, ask.seed), records, ask)


def outcome_of(
    command: str, study: Study, model: Model, records: list[Record], ask: Request
) -> Outcome:
    """JSON and view of a study."""
    result = {"command": command, **diagnosis_json(study, model)}
    result["by_record"] = by_record(study.diagnosis, study.problem, study.records or records)
    if study.long is not None:
        result["long"] = study.long
    origin = provenance(records, study.model, ask)
    result["history"] = [dict(h) for h in model.history]
    tables = study_regions(study, ask.seed)
    result["regions"], result["worst"] = regions_json(tables), worst(tables)
    result["preflight"] = preflight(
        originals(records), study.model, study.model.catalogue
    ).as_json()
    result["provenance"] = origin
    if study.problem.fused:
        result["fusion"] = fusion_json(originals(records), study.problem)
    if ask.level == "damper":
        result["next"] = suggestions(
            result, ask.model_file, ask.data, ask.effects_from, anyway=ask.anyway
        )
    result = clean(result)
    return Outcome(
        result,
        replace(study_view(command, study, result, origin), regions=tables),
        model,
        study.problem.complete,
    )
