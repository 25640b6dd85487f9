"""`lab identify`, apart from how it is called."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from er_models.files import save_model

from er_model_lab.commands import Outcome, Request, command_line, provenance, read
from er_model_lab.identify.present import identified_json, new_model, view
from er_model_lab.identify.procedure import identify
from er_model_lab.load import fingerprint

STEPS = 4
"""Ticks of the progress in most cases: three stages and the joint refinement."""


def run(ask: Request, out: Path, tick: Callable[[str], None] | None = None) -> Outcome:
    """Identify the parameters of a model, and write the new model."""
    model, (records, sealed) = ask.model(), read(ask)
    found = identify(records, model, sealed=sealed, tick=tick)
    result = identified_json(found)
    entry = {
        "command_line": command_line(), "data": fingerprint(records), "records": [r.name for r in records],
        "seed": ask.seed,
    }  # fmt: skip
    grown = new_model(found, out.stem, entry)
    result["model"] = grown.name
    drawn = view(found, result, ask.seed, provenance(records, model, ask))
    save_model(grown, out)
    return Outcome(result, drawn, grown, bool(result["complete"]))
