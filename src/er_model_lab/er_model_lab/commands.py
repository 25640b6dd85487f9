"""What each command of the lab does, apart from how it is called."""

from __future__ import annotations

import shlex
import sys
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from er_models.catalogue import Catalogue
from er_models.errors import ErError, InputError
from er_models.files import load_model, save_model
from er_models.model import Array, Model
from er_models.own import catalogue_with

from er_model_lab.blas import on_one_thread
from er_model_lab.compare import errors, regions_json, size_notes, worst
from er_model_lab.copies import check_apart
from er_model_lab.diagnose.by_record import by_record
from er_model_lab.diagnose.candidates import Candidate, baseline
from er_model_lab.diagnose.floor import Floor, noise_floor
from er_model_lab.diagnose.null import simulate_null
from er_model_lab.driven import driven
from er_model_lab.envelope import in_bounds
from er_model_lab.excess import noise_at, region_tables
from er_model_lab.floors import floors
from er_model_lab.fusion import fusion_json
from er_model_lab.learnt import REACH, Beyond, beyond, reach
from er_model_lab.load import fingerprint, load, told_apart
from er_model_lab.long.choose import shortened
from er_model_lab.long.verify import Checked, checked, errors_json, long_json, long_note
from er_model_lab.passes import explained_by, taken_last, told_together
from er_model_lab.plan.suggest import suggestions
from er_model_lab.preflight.check import gate, preflight
from er_model_lab.preflight.size import off_centre
from er_model_lab.prepare import Problem
from er_model_lab.present import (
    candidate_views,
    clean,
    compare_json,
    diagnosis_json,
    headline,
    study_regions,
    study_view,
    views,
)
from er_model_lab.record import Record, originals
from er_model_lab.resume import Begun, finished, marked, resume, with_fits
from er_model_lab.rule import RULE, Rule
from er_model_lab.side_by_side import Rival, fitted_to, names, overlaid, table
from er_model_lab.study import (
    Study,
    Tick,
    add_effect,
    as_given,
    final_model,
    investigate,
    open_problem,
)
from er_model_lab.velocity_channel import as_searched, on_fused
from er_model_lab.versions import versions
from er_model_lab.view import RegionTable, View

MOST_PASSES = 10
"""How often `improve` diagnoses the model it has just improved."""


@dataclass(frozen=True)
class Request:
    """What every command is asked: data, data that only score (may be empty), model file and seed.

    effects_from: Python files with the user's own effects; rule: when an effect is worth a name;
    level: damper or vehicle; anyway: whether data that fail the preflight are used all the same;
    rivals: further models for `compare`.
    """

    data: list[Path]
    model_file: Path
    seed: int = 0
    hold_out: tuple[Path, ...] = ()
    effects_from: tuple[Path, ...] = ()
    rule: Rule = RULE
    level: str = "damper"
    anyway: bool = False
    rivals: tuple[Path, ...] = ()

    @property
    def catalogue(self) -> Catalogue:
        """The catalogue with the user's own effects."""
        return catalogue_with(self.effects_from)

    def model(self) -> Model:
        """The model as its file has it."""
        return load_model(self.model_file, self.catalogue)

    def others(self) -> list[tuple[Path, Model]]:
        """Further models to compare with it."""
        return [(path, load_model(path, self.catalogue)) for path in self.rivals]


@dataclass(frozen=True)
class Outcome:
    """Result of a command: the contract's JSON, what to draw, and the new model if there is one.

    interrupted: Ctrl-C ended it, and what was done until then is in the result.
    """

    result: dict[str, Any]
    view: View
    model: Model | None
    complete: bool
    interrupted: bool = False


def command_line() -> str:
    """The command as it was typed, for whoever wants the same result again."""
    words = sys.argv[1:] if Path(sys.argv[0]).name in ("cli.py", "er-lab") else []
    return " ".join(["./er lab", *map(shlex.quote, words)]) if words else ""


def read(ask: Request) -> tuple[list[Record], int]:
    """Records to learn from followed by those that only score, and how many the latter are.

    Of data that are too long to be searched whole, stretches of them.
    """
    records = load(ask.data)
    sealed = load(ask.hold_out) if ask.hold_out else []
    if not records:
        raise InputError(ask.data[0], "", "at least one record", "none")
    check_apart(records, sealed)
    data = gate(told_apart([*records, *sealed]), anyway=ask.anyway)
    if ask.level == "vehicle":
        return shortened(data, len(sealed))
    return shortened(*driven(data, len(sealed)))


def provenance(records: list[Record], model: Model, ask: Request) -> dict[str, Any]:
    """Where a result comes from: data, model, seed and versions."""
    data = originals(records)
    return {
        "data": fingerprint(data), "records": [r.name for r in data], "model_file": str(ask.model_file),
        "model": model.digest(), "seed": ask.seed, "versions": versions(), "command_line": command_line(),
        "effects_from": {name: asdict(o) for name, o in model.catalogue.origins.items()},
    }  # fmt: skip


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
    result = compare_json(
        problem, given, floor.floor, max(1.0 - floor.floor**2 / mse, 0.0), tables
    ) | {
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


@on_one_thread
def diagnose(ask: Request, tick: Tick | None = None) -> Outcome:
    """Refit, then say which effect is missing."""
    model, (records, sealed) = ask.model(), read(ask)
    study = investigate(
        records, model, seed=ask.seed, sealed=sealed, rule=ask.rule, tick=tick, level=ask.level
    )
    return _outcome("diagnose", study, final_model(study, ask.seed), records, ask)


@on_one_thread
def add(ask: Request, effect: str, out: Path, tick: Tick | None = None) -> Outcome:
    """Add one effect, refit everything, and write the new model."""
    model, (records, sealed) = ask.model(), read(ask)
    _may_add(model, effect, ask.level)
    study = add_effect(
        records, model, effect, seed=ask.seed, sealed=sealed, tick=tick, level=ask.level
    )
    grown = _with_history(final_model(study, ask.seed), model, study, records, ask.seed, out)
    outcome = _outcome("add", study, grown, records, ask)
    save_model(grown, out)
    return outcome


@on_one_thread
def improve(ask: Request, out: Path, tick: Tick | None = None) -> Outcome:
    """Diagnose and add until the model is adequate or nothing known helps; the new model is refitted in any case.

    Ctrl-C ends it with what was done until then, from which the same command goes on later to the same end.
    """
    model, (records, sealed) = ask.model(), read(ask)
    begun = resume(out, model, records, ask.catalogue)
    current, studies, stopped = model, list[Study](), False
    for n in range(MOST_PASSES):
        try:
            study = investigate(
                records, current, seed=ask.seed + 1000 * n, sealed=sealed, rule=ask.rule, tick=tick, level=ask.level,
                noted=begun.noted,
            )  # fmt: skip
            best = final_model(study, ask.seed)
        except KeyboardInterrupt:
            if not studies:
                raise
            stopped = True
            break
        studies.append(study)
        records = list(study.records)  # of long data with the stretches where the model did worst
        found = study.diagnosis
        refitted = current is model and (
            found.verdict != "insufficient_data" or not found.coverage.blocking
        )
        if study.diagnosis.effects or refitted:
            current = _with_history(best, current, study, records, ask.seed, out)
            current = marked(current, begun.digest)
        stopped = study.diagnosis.interrupted
        if stopped or study.diagnosis.verdict != "partial":
            break
    current = finished(current, interrupted=stopped)
    outcome = gone_on(_improved(studies, current, records, ask), begun, out)
    save_model(with_fits(current, begun.noted) if stopped else current, out)
    return replace(outcome, interrupted=stopped, result=outcome.result | {"interrupted": stopped})


def _improved(studies: list[Study], model: Model, records: list[Record], ask: Request) -> Outcome:
    """The outcome of several passes as one fall of the error."""
    first, last = studies[0], studies[-1]
    outcome = _outcome("improve", first, model, records, ask)
    results = [outcome.result, *(_later(s, model, records) for s in studies[1:])]
    cards = [outcome.view.candidates]
    cards += [candidate_views(s, r) for s, r in zip(studies[1:], results[1:], strict=True)]
    result = told_together(results)
    view = replace(outcome.view, candidates=taken_last(cards, results))
    if len(studies) > 1:
        result |= explained_by(first.diagnosis, last.diagnosis)
        view = replace(view, headline=headline(result["rmse"]["held_out"], result["noise_floor"]))
        after = last.problem.force - last.diagnosis.best.fit.residual
        view = replace(view, records=views(last.problem, _before(first, last), after))
    if first.long is not None and last.long is not None:
        told, now = long_note(first.long), long_note(last.long)
        result["notes"] = [now if note == told else note for note in result["notes"]]
        view = replace(view, notes=tuple(now if note == told else note for note in view.notes))
    return Outcome(result, replace(view, result=result), model, outcome.complete)


def _before(first: Study, last: Study) -> Array:
    """What the model before all passes predicts of the samples of the last one (n,) [N]."""
    fitted = first.diagnosis.base.fit
    if np.array_equal(first.problem.force, last.problem.force):
        return np.asarray(first.problem.force - fitted.residual)
    return last.problem.predict(as_searched(fitted))


def _later(study: Study, model: Model, records: list[Record]) -> dict[str, Any]:
    """The JSON of a pass after the first."""
    left = by_record(study.diagnosis, study.problem, study.records or records)
    told = diagnosis_json(study, model) | {"by_record": left}
    found: dict[str, Any] = clean(told | ({"long": study.long} if study.long else {}))
    return found


def gone_on(outcome: Outcome, begun: Begun, out: Path) -> Outcome:
    """The outcome with a note where an interruption had left something to go on from."""
    if begun.added is None:
        return outcome
    note = f"went on from {out}, which an interruption had left with {len(begun.added)} done"
    outcome.result["notes"] = [note, *outcome.result["notes"]]
    return replace(outcome, view=replace(outcome.view, notes=(note, *outcome.view.notes)))


def _outcome(
    command: str, study: Study, model: Model, records: list[Record], ask: Request
) -> Outcome:
    """JSON and view of a study."""
    result = {"command": command, **diagnosis_json(study, model)}
    result["by_record"] = by_record(study.diagnosis, study.problem, study.records or records)
    if study.long is not None:
        result["long"] = study.long
    origin = provenance(records, study.model, ask)
    result["history"] = [dict(h) for h in model.history]
    tables = study_regions(study, ask.seed)
    result["regions"], result["worst"] = regions_json(tables), worst(tables)
    result["preflight"] = preflight(
        originals(records), study.model, study.model.catalogue
    ).as_json()
    result["provenance"] = origin
    if study.problem.fused:
        result["fusion"] = fusion_json(originals(records), study.problem)
    if ask.level == "damper":
        result["next"] = suggestions(
            result, ask.model_file, ask.data, ask.effects_from, anyway=ask.anyway
        )
    result = clean(result)
    return Outcome(
        result,
        replace(study_view(command, study, result, origin), regions=tables),
        model,
        study.problem.complete,
    )


def _may_add(model: Model, effect: str, level: str) -> None:
    """An effect must exist, be knowable, and not be in the model yet."""
    known = model.catalogue[effect]
    if not known.knowable:
        raise ErError(f"{effect} cannot be known from these channels: {known.unknowable_because}")
    if effect in model.effects:
        raise ErError(f"{effect} is already part of the model '{model.name}'")
    if known.stage == "vehicle" and level != "vehicle":
        raise ErError(f"{effect} acts in the vehicle, not in the damper: --level vehicle adds it")


def _with_history(
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
