"""What is wrong with measurements, and what they cannot show, before anything is fitted."""

from __future__ import annotations

from er_common.command_line import command_line
from er_common.versions import versions
from er_models.catalogue import CATALOGUE
from er_models.model import Model
from er_records.dataset import Dataset
from er_records.load import fingerprint

from er_model_lab.preflight.check import preflight
from er_model_lab.preflight.wild import marked, outliers
from er_model_lab.results.result import CheckResult
from er_model_lab.results.values import clean
from er_model_lab.view import View


def check(data: Dataset, model: Model | None = None) -> CheckResult:
    """Check all records; with a model, coverage is measured against the reach of its rig."""
    records = tuple(marked(r) for r in data.records)
    found = preflight(records, model, model.catalogue if model else CATALOGUE, levels=True)
    seconds = sum(len(r) * r.dt for r in records)
    warnings = found.counted("warning")
    notes = tuple(dict.fromkeys(n for r in records for n in r.notes))
    result = clean({
        "command": "check", "verdict": found.verdict, "preflight": found.as_json(),
        "notes": list(notes), "outliers": outliers(records), "complete": all(r.complete for r in records),
    })  # fmt: skip
    what = records[0].name if len(records) == 1 else f"{len(records)} records"
    line = (
        f"{len(records)} record{'s' * (len(records) != 1)}, {seconds:.4g} s: "
        f"{len(found.failures)} failed, {warnings} warning{'s' * (warnings != 1)}"
    )
    origin = {
        "data": fingerprint(records), "records": [r.name for r in records], "versions": versions(),
        "command_line": command_line(),
    }  # fmt: skip
    if model and model.file:
        origin["model_file"] = model.file
    return CheckResult(
        View(
            command="check", model=model.name if model else what, headline=line, result=result, records=(),
            notes=notes, provenance=origin,
        )
    )  # fmt: skip
