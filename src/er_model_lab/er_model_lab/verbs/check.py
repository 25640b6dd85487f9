"""`lab check`: what is wrong with measurements, and what they cannot show, before anything is fitted."""

from __future__ import annotations

from pathlib import Path

from er_models.files import load_model
from er_models.own import catalogue_with

from er_model_lab.command_line import command_line
from er_model_lab.preflight.check import preflight
from er_model_lab.records.load import fingerprint, load
from er_model_lab.results.values import clean
from er_model_lab.results.view import View
from er_model_lab.verbs.ask import Outcome
from er_model_lab.versions import versions


def run(data: list[Path], model_file: Path | None, effects_from: tuple[Path, ...] = ()) -> Outcome:
    """Check all records; with a model, coverage is measured against the reach of its rig."""
    catalogue = catalogue_with(effects_from)
    model = load_model(model_file, catalogue) if model_file else None
    records = load(data)
    found = preflight(records, model, catalogue, levels=True)
    seconds = sum(len(r) * r.dt for r in records)
    warnings = found.counted("warning")
    complete = all(r.complete for r in records)
    notes = tuple(dict.fromkeys(n for r in records for n in r.notes))
    result = clean({
        "command": "check", "verdict": found.verdict, "preflight": found.as_json(),
        "notes": list(notes), "complete": complete,
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
    if model_file:
        origin["model_file"] = str(model_file)
    view = View(
        command="check", model=model.name if model else what, headline=line, result=result, records=(),
        notes=notes, provenance=origin,
    )  # fmt: skip
    return Outcome(result, view, None, complete)
