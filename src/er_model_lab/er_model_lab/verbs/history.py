"""A grown model carries where it comes from: data, seed, verdict and errors, one entry a step."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from er_common.command_line import command_line
from er_models.model import Model
from er_records.load import fingerprint

from er_model_lab.fitting.data_reach import REACH, reach
from er_model_lab.fitting.envelope import in_bounds
from er_model_lab.fitting.rig import kept_up, with_old_envelope
from er_model_lab.level.study import Study
from er_model_lab.residual.errors import errors


def with_history(grown: Model, before: Model, study: Study, seed: int, name: str) -> Model:
    """The grown model under its new name, with one entry of history more."""
    found, problem, records = study.diagnosis, study.problem, study.data.originals
    held = problem.held_out
    entry: dict[str, Any] = {
        "added": [
            *(e for e in grown.effects if e not in before.effects),
            *(t.name for t in grown.terms if t not in before.terms),
        ],
        "verdict": found.verdict,
        "command_line": command_line(),
        "data": fingerprint(records),
        "records": [r.name for r in records],
        "seed": seed,
        "rmse_held_out": {
            "before": errors(problem, found.base.fit.residual, held).rmse,
            "after": errors(problem, found.best.fit.residual, held).rmse,
        },
        "noise_floor": found.floor.first.held_out,
        "from": before.name,
    }
    if problem.fused:
        entry[REACH] = reach(problem)
    source = f"fitted to {len(records)} records, beginning from '{before.name}' ({before.source})"
    named = replace(grown, name=name, source=source, history=(*before.history, entry), file="")
    return with_old_envelope(kept_up(in_bounds(named, problem, before.scales), problem), before)
