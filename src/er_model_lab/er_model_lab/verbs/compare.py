"""`lab compare`: predict with the model as it is, and say where it fails; several models side by side."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from er_models.model import Array, Model

from er_model_lab.blas import on_one_thread
from er_model_lab.diagnosis.candidates import Candidate, baseline
from er_model_lab.diagnosis.floor_estimates import floors
from er_model_lab.diagnosis.noise_floor import Floor, noise_floor
from er_model_lab.diagnosis.null import simulate_null
from er_model_lab.diagnosis.study import (
    as_given,
    open_problem,
)
from er_model_lab.fitting.data_reach import Beyond, beyond
from er_model_lab.fitting.velocity_channel import on_fused
from er_model_lab.long.check import Checked, checked, errors_json, long_json, long_note
from er_model_lab.preflight.check import preflight
from er_model_lab.preflight.size import off_centre
from er_model_lab.problem.problem import Problem
from er_model_lab.records.load import fingerprint
from er_model_lab.records.record import Record, originals
from er_model_lab.residual.errors import explainable, size_notes
from er_model_lab.residual.excess import noise_at, region_tables
from er_model_lab.results.comparison import compare_json
from er_model_lab.results.fusion import fusion_json
from er_model_lab.results.side_by_side import Rival, fitted_to, names, overlaid, table
from er_model_lab.results.values import clean, headline
from er_model_lab.results.view import RegionTable, View
from er_model_lab.results.views import views
from er_model_lab.verbs.ask import Outcome, Request, provenance, read


@on_one_thread
def compare(ask: Request) -> Outcome:
    """Predict with the model as it is, and say where it fails."""
    model, (records, sealed) = ask.model(), read(ask)
    problem, _ = open_problem(records, model, sealed)
    given = as_given(model, problem)
    base = baseline(on_fused(model), problem)
    null = simulate_null(base, [], problem, ask.seed)
    floor = noise_floor(problem, base, null, ask.seed)
    noise = noise_at(problem, floor.floor, null.input_square)
    tables = region_tables(problem, given, ask.seed, noise)
    result, notes, on_all = _compared(records, model, problem, given, base, floor, tables)
    others, theirs = _rivals(ask, records, sealed, noise)
    result["notes"] = [*theirs, *notes]
    view = View(
        command="compare", model=model.name, headline=headline(result["rmse"], floor.floor), result=clean(result),
        records=views(problem, problem.force - given, None), regions=tables, notes=(*theirs, *notes),
        provenance=provenance(records, model, ask),
    )  # fmt: skip
    data = fingerprint(originals(records))
    first = Rival(model, str(ask.model_file), view.records, fitted_to(model, data), tables, on_all)
    view = beside(view, [first, *others], floor.floor, ask.seed)
    return Outcome(dict(view.result), view, None, problem.complete)


def _compared(
    records: list[Record], model: Model, problem: Problem, given: Array, base: Candidate, floor: Floor,
    tables: tuple[RegionTable, ...],
) -> tuple[dict[str, Any], tuple[str, ...], Checked | None]:  # fmt: skip
    """The JSON of one model on its data, without notes, the notes, and what the model leaves of long data.

    given (n,): what the model leaves [N]. Of long data the errors are those on all of them.
    """
    further, data = beyond(model, problem, given), originals(records)
    mse = float(np.mean(given[problem.used] ** 2))
    sides = floors(problem, base.fit.residual, floor)
    result = compare_json(problem, given, floor.floor, explainable(mse, floor.floor), tables) | {
        "preflight": preflight(data, model, model.catalogue).as_json(),
        "command": "compare",
        "model": model.name,
        "floors": {name: side.as_json() for name, side in sides.items()},
        "fusion": fusion_json(data, problem),
        "rmse_refitted": float(np.sqrt(base.mse)),
        "beyond": further.as_json() if further else None,
    }
    centre = tuple(dict.fromkeys(n for r in data for n in _centre(r, model)))
    notes = (*size_notes(problem, given), *centre, *_further(model, further), *problem.notes)
    on_all = checked(problem, given, given=on_fused(model))
    if on_all is not None:
        result["long"] = long_json(on_all, again=False)
        result |= errors_json(on_all, floor.floor)
        notes = (long_note(result["long"]), *notes)
    return result, notes, on_all


def _centre(record: Record, model: Model) -> tuple[str, ...]:
    """What is said of a deflection whose middle lies beyond what the model is made for."""
    middle, reach = off_centre(record, model), model.scales.deflection
    if not middle:
        return ()
    return (
        f"the deflection's middle is at {1e3 * middle:.3g} mm, the model is made for {1e3 * reach:.3g} mm to either "
        "side: the sensor's zero may be another (deflection_zero)",
    )


def _rivals(
    ask: Request, records: list[Record], sealed: int, noise: Array
) -> tuple[list[Rival], tuple[str, ...]]:
    """Further models on the same data, and what is to be said of them."""
    data, found, notes = fingerprint(originals(records)), [], tuple[str, ...]()
    for path, model in ask.others():
        problem, _ = open_problem(records, model, sealed)
        left = as_given(model, problem)
        notes = (*_further(model, beyond(model, problem, left)), *notes)
        regions = region_tables(problem, left, ask.seed, noise)
        seen = views(problem, problem.force - left, None)
        on_all = checked(problem, left, given=on_fused(model))
        found.append(Rival(model, str(path), seen, fitted_to(model, data), regions, on_all))
    return found, notes


def _further(model: Model, found: Beyond | None) -> tuple[str, ...]:
    """What is said of data that go beyond what a model was fitted to."""
    return (found.note(model.name),) if found and found.matters else ()


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
