"""`lab identify`, apart from how it is called."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from er_models.files import save_model

from er_model_lab.command_line import command_line
from er_model_lab.fitting.velocity_channel import on_fused
from er_model_lab.identify.present import identified_json, new_model, view
from er_model_lab.identify.procedure import identify
from er_model_lab.long.check import told
from er_model_lab.records.load import fingerprint
from er_model_lab.records.record import originals
from er_model_lab.verbs.ask import Outcome, Request, provenance, read
from er_model_lab.work import HERE, Work


def run(ask: Request, out: Path, work: Work = HERE) -> Outcome:
    """Identify the parameters of a model, and write the new model."""
    model, (records, sealed) = ask.model(), read(ask)
    found = identify(records, model, sealed=sealed, work=work)
    before, after = on_fused(found.before), on_fused(found.model)
    problem, long = told(found.problem, found.residual, before=before, after=after)
    found = replace(found, problem=problem)
    result, data = identified_json(found) | long, originals(records)
    entry = {
        "command_line": command_line(), "data": fingerprint(data), "records": [r.name for r in data], "seed": ask.seed,
    }  # fmt: skip
    grown = new_model(found, out.stem, entry)
    result["model"] = grown.name
    drawn = view(found, result, ask.seed, provenance(records, model, ask))
    save_model(grown, out)
    return Outcome(result, drawn, grown, bool(result["complete"]))
