"""What a model as it is makes of data, and several side by side: the work behind `compare`."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from er_models.model import Array, Model
from er_records.load import fingerprint

from er_model_lab.level.level import Judged, Question
from er_model_lab.level.study import Opened
from er_model_lab.preflight.wild import outliers
from er_model_lab.residual.excess import region_tables
from er_model_lab.residual.region import RegionTable
from er_model_lab.results.comparison import compare_json
from er_model_lab.results.draw import views
from er_model_lab.results.result import ComparisonResult
from er_model_lab.results.side_by_side import Rival, fitted_to, names, overlaid, table
from er_model_lab.results.values import clean, headline
from er_model_lab.span.check import Checked
from er_model_lab.verbs.asking import provenance
from er_model_lab.view import View


def compared(asked: Question, others: tuple[Model, ...]) -> ComparisonResult:
    """The data predicted with the model that is asked about, and with others beside it."""
    judged, model, seed = asked.level.judged(asked), asked.model, asked.seed
    problem, given = judged.opened.problem, judged.opened.given
    tables = region_tables(problem, given, seed, judged.noise)
    whole = _on_all(judged.opened)
    rivals, further = _rivals(asked, others, judged.noise)
    content = _content(asked, judged, tables, whole)
    notes = (*further, *_notes(asked, judged, whole))
    view = View(
        command="compare", model=model.name, headline=headline(content["rmse"], judged.floor),
        result=content | {"notes": list(notes)}, records=views(problem, problem.force - given, None), regions=tables,
        notes=notes, provenance=provenance(asked.data, model, seed),
    )  # fmt: skip
    first = _rival(asked, model, judged.opened, tables, whole)
    return ComparisonResult(beside(view, [first, *rivals], judged.floor, seed))


def _content(
    asked: Question, judged: Judged, tables: tuple[RegionTable, ...], whole: Checked | None
) -> dict[str, Any]:
    """The result of one model without its notes; of long data the errors are those on all of them."""
    content = compare_json(judged.opened.problem, judged.opened.given, judged.floor, tables)
    content |= {"command": "compare", "model": asked.model.name, **judged.content}
    beside = judged.opened.problem.beside
    content["outliers"] = outliers(asked.data.originals, beside)
    content["preflight"] = asked.preflight.as_json()
    if whole is not None:
        content |= {"long": whole.as_json(again=False), **whole.errors(judged.floor)}
    return content


def _notes(asked: Question, judged: Judged, whole: Checked | None) -> tuple[str, ...]:
    """What to know of data and model, what was used of long data first."""
    long = (whole.note(again=False),) if whole else ()
    reach = asked.level.reach_notes(judged.opened)
    return (*long, *judged.notes, *reach, *judged.opened.problem.notes)


def _on_all(opened: Opened) -> Checked | None:
    """What the model leaves of all of long data."""
    return opened.span.checked(opened.problem, opened.given, given=opened.searched)


def _rivals(
    asked: Question, others: tuple[Model, ...], noise: Array
) -> tuple[list[Rival], tuple[str, ...]]:
    """Further models on the same data, and what is to be said of them."""
    found, notes = list[Rival](), tuple[str, ...]()
    for model in others:
        opened = asked.level.given(replace(asked, model=model))
        tables = region_tables(opened.problem, opened.given, asked.seed, noise)
        found.append(_rival(asked, model, opened, tables, _on_all(opened)))
        notes = (*asked.level.reach_notes(opened), *notes)
    return found, notes


def _rival(
    asked: Question, model: Model, opened: Opened, tables: tuple[RegionTable, ...],
    whole: Checked | None,
) -> Rival:  # fmt: skip
    """A model as it stands beside others."""
    problem = opened.problem
    seen = views(problem, problem.force - opened.given, None)
    here = fitted_to(model, fingerprint(asked.data.originals))
    return Rival(model, seen, here, tables, whole)


def beside(view: View, rivals: list[Rival], floor: float, seed: int) -> View:
    """The view of the first of several models with the others beside it, and with each one's history."""
    result = {**view.result, "history": [dict(h) for h in rivals[0].model.history]}
    if len(rivals) == 1:
        return replace(view, result=clean(result))
    result["models"] = table(rivals, floor, seed)
    called = names(rivals)
    return replace(
        view, result=clean(result), records=overlaid(rivals),
        rival_regions=tuple(zip(called, (r.regions for r in rivals), strict=True)),
    )  # fmt: skip
