"""Predict with a model as it is, and say where it fails; several models side by side."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import replace

from er_common.command_line import command_line
from er_common.kept import kept
from er_common.versions import versions
from er_models.model import Model
from er_records.dataset import Dataset

from er_model_lab.blas import on_one_thread
from er_model_lab.results.result import ComparisonResult
from er_model_lab.work import Event, Progress, Work

SOURCES = ("er_model_lab", "er_records", "er_common")
"""Packages that decide a comparison, beside `er_models`, which always counts."""


@on_one_thread
def compare(
    data: Dataset,
    model: Model,
    *others: Model,
    held_out: Dataset | None = None,
    level: str = "damper",
    seed: int = 0,
    anyway: bool = False,
    progress: Progress | None = None,
    cancel: Event | None = None,
    executor: Executor | None = None,
) -> ComparisonResult:
    """Predict the data with the model as it is, and with others beside it, and say where it fails.

    What was compared before is found again (`er_common.kept`).
    """

    def made() -> ComparisonResult:
        from er_model_lab.verbs.asking import question
        from er_model_lab.verbs.compared import compared

        work = Work(executor, progress, cancel)
        asked = question(
            data, model, held_out=held_out, level=level, seed=seed, anyway=anyway, work=work
        )
        return compared(asked, others)

    result = kept(SOURCES, (data, held_out, model, others, level, seed, anyway), made)
    now = {"command_line": command_line(), "versions": versions()}
    view = replace(result.view, provenance={**result.view.provenance, **now})
    return replace(result, view=view)
