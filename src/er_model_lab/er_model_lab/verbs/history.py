"""A grown model carries where it comes from: data, seed, verdict and errors, one entry a step."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from er_models.model import Model

from er_model_lab.command_line import command_line
from er_model_lab.diagnosis.study import (
    Study,
)
from er_model_lab.fitting.data_reach import REACH, reach
from er_model_lab.fitting.envelope import in_bounds
from er_model_lab.records.load import fingerprint
from er_model_lab.records.record import Record, originals
from er_model_lab.residual.errors import errors


def with_history(
    grown: Model, before: Model, study: Study, records: list[Record], seed: int, out: Path
) -> Model:
    """The grown model under its new name, with one entry of history more."""
    found = study.diagnosis
    held = study.problem.held_out
    entry: dict[str, Any] = {
        "added": [e for e in grown.effects if e not in before.effects],
        "verdict": found.verdict,
        "command_line": command_line(),
        "data": fingerprint(originals(records)),
        "records": [r.name for r in originals(records)],
        "seed": seed,
        "rmse_held_out": {
            "before": errors(study.problem, found.base.fit.residual, held).rmse,
            "after": errors(study.problem, found.best.fit.residual, held).rmse,
        },
        "noise_floor": found.floor.first.held_out,
        "from": before.name,
    }
    if study.problem.fused:
        entry[REACH] = reach(study.problem)
    source = f"fitted to {len(originals(records))} records, beginning from '{before.name}' ({before.source})"
    named = replace(grown, name=out.stem, source=source, history=(*before.history, entry))
    return in_bounds(named, study.problem, before.scales)
