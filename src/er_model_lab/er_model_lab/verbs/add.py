"""`lab add`: add one effect, refit everything, and write the new model."""

from __future__ import annotations

from pathlib import Path

from er_models.errors import ErError
from er_models.files import save_model
from er_models.model import Model

from er_model_lab.blas import on_one_thread
from er_model_lab.diagnosis.study import (
    add_effect,
    final_model,
)
from er_model_lab.verbs.ask import Outcome, Request, read
from er_model_lab.verbs.diagnose import outcome_of
from er_model_lab.verbs.history import with_history
from er_model_lab.work import HERE, Work


@on_one_thread
def add(ask: Request, effect: str, out: Path, work: Work = HERE) -> Outcome:
    """Add one effect, refit everything, and write the new model."""
    model, (records, sealed) = ask.model(), read(ask)
    _may_add(model, effect, ask.level)
    study = add_effect(
        records, model, effect, seed=ask.seed, sealed=sealed, work=work, level=ask.level
    )
    grown = with_history(final_model(study, ask.seed), model, study, records, ask.seed, out)
    outcome = outcome_of("add", study, grown, records, ask)
    save_model(grown, out)
    return outcome


def _may_add(model: Model, effect: str, level: str) -> None:
    """An effect must exist, be knowable, and not be in the model yet."""
    known = model.catalogue[effect]
    if not known.knowable:
        raise ErError(f"{effect} cannot be known from these channels: {known.unknowable_because}")
    if effect in model.effects:
        raise ErError(f"{effect} is already part of the model '{model.name}'")
    if known.stage == "vehicle" and level != "vehicle":
        raise ErError(f"{effect} acts in the vehicle, not in the damper: --level vehicle adds it")
