"""Add one effect, or none, refit everything, and show the error before and after."""

from __future__ import annotations

from concurrent.futures import Executor

from er_models.errors import ErError
from er_models.model import Model
from er_records.dataset import Dataset

from er_model_lab.blas import on_one_thread
from er_model_lab.level.investigate import added
from er_model_lab.level.level import Question
from er_model_lab.level.study import Study
from er_model_lab.results.by_record import with_flags
from er_model_lab.results.result import DiagnosisResult
from er_model_lab.verbs.asking import question
from er_model_lab.verbs.diagnose import result_of
from er_model_lab.verbs.history import with_history
from er_model_lab.work import Cancelled, Event, Progress, Work


@on_one_thread
def add(
    data: Dataset,
    model: Model,
    effect: str,
    *,
    name: str | None = None,
    held_out: Dataset | None = None,
    level: str = "damper",
    seed: int = 0,
    anyway: bool = False,
    progress: Progress | None = None,
    cancel: Event | None = None,
    executor: Executor | None = None,
) -> DiagnosisResult:
    """Add one effect and refit everything; the result holds the new model, under `name`."""
    _may_add(model, effect, level)
    asked = question(
        data,
        model,
        held_out=held_out,
        level=level,
        seed=seed,
        anyway=anyway,
        work=Work.by(executor, progress, cancel),
    )
    study, grown = _refitted(asked, effect, name or f"{model.name}_{effect}")
    return with_flags(result_of("add", study, grown, asked))


@on_one_thread
def refit(
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
) -> Model:
    """The damper's model with every parameter refitted, under `name`; measured terms keep their values.

    Raises:
        Cancelled: It was.
    """
    work = Work.by(executor, progress, cancel)
    asked = question(data, model, held_out=held_out, seed=seed, anyway=anyway, work=work)
    study, made = _refitted(asked, None, name or f"{model.name}_refitted")
    if study.diagnosis.interrupted:
        raise Cancelled
    return made


def _refitted(asked: Question, effect: str | None, name: str) -> tuple[Study, Model]:
    """The study of one effect more, or none, and its model under the new name."""
    study = added(asked, effect)
    best = asked.level.finished(study, asked.seed)
    return study, with_history(best, asked.model, study, asked.seed, name)


def _may_add(model: Model, effect: str, level: str) -> None:
    """An effect must exist, be knowable, and not be in the model yet."""
    known = model.catalogue[effect]
    if not known.knowable:
        raise ErError(f"{effect} cannot be known from these channels: {known.unknowable_because}")
    if effect in model.effects:
        raise ErError(f"{effect} is already part of the model '{model.name}'")
    if known.stage == "vehicle" and level != "vehicle":
        raise ErError(f"{effect} acts in the vehicle, not in the damper: level='vehicle' adds it")
