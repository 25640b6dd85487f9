"""Identify every parameter of a model in stages, as in chapter 1 of the thesis."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import replace

from er_common.command_line import command_line
from er_models.model import Model
from er_records.dataset import Dataset
from er_records.load import fingerprint

from er_model_lab.fitting.rig import rig_note
from er_model_lab.fitting.velocity_channel import on_fused
from er_model_lab.identification.present import identified_json, new_model, view
from er_model_lab.identification.procedure import identified
from er_model_lab.preflight.wild import outliers
from er_model_lab.results.result import IdentificationResult, with_notes
from er_model_lab.span.span import noted
from er_model_lab.verbs.asking import provenance, question
from er_model_lab.work import Event, Progress, Work


def identify(
    data: Dataset,
    model: Model,
    *,
    name: str | None = None,
    held_out: Dataset | None = None,
    seed: int = 0,
    anyway: bool = False,
    progress: Progress | None = None,
    cancel: Event | None = None,
    executor: Executor | None = None,
) -> IdentificationResult:
    """Identify the parameters of a model; the result holds the new model, under `name`."""
    asked = question(
        data,
        model,
        held_out=held_out,
        seed=seed,
        anyway=anyway,
        work=Work.by(executor, progress, cancel),
    )
    found = identified(asked.data, model, asked.work)
    before, after = on_fused(found.before), on_fused(found.model)
    whole = found.span.checked(found.problem, found.residual, before=before, after=after)
    found = replace(found, problem=noted(found.problem, whole))
    records = asked.data.originals
    entry = {
        "command_line": command_line(), "data": fingerprint(records), "records": [r.name for r in records],
        "seed": seed,
    }  # fmt: skip
    grown = new_model(found, name or f"{model.name}_identified", entry)
    content = identified_json(found) | {"model": grown.name}
    content["outliers"] = outliers(records, found.problem.beside)
    if whole is not None:
        content["long"] = whole.as_json(again=False)
    drawn = view(found, content, seed, provenance(asked.data, model, seed))
    return with_notes(IdentificationResult(drawn, grown), last=rig_note(grown, model))
