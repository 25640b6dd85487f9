"""Commands that look for what a model lacks: diagnose, add, improve."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from er_models.errors import ErError

from er_model_lab.cli.options import (
    Anyway,
    Data,
    EffectsFrom,
    FalseAlarm,
    Helps,
    HoldOut,
    Json,
    Level,
    MeasuredTerms,
    ModelFile,
    Out,
    Report,
    Seed,
    Smallest,
)
from er_model_lab.cli.running import loaded, progress, read_by, run
from er_model_lab.diagnosis.rule import RULE, Rule

if TYPE_CHECKING:
    from er_models.model import Model

    from er_model_lab.results.result import Result


def diagnose_command(
    data: Data,
    model: ModelFile,
    json_file: Json = None,
    report: Report = None,
    hold_out: HoldOut = None,
    effects_from: EffectsFrom = None,
    level: Level = "damper",
    seed: Seed = 0,
    false_alarm: FalseAlarm = RULE.false_alarm,
    smallest: Smallest = RULE.smallest,
    helps: Helps = RULE.helps,
    anyway: Anyway = False,
) -> None:
    """Refit the model, then say which effect is missing, with evidence."""

    def work() -> Result:
        from er_model_lab.verbs.diagnose import diagnose
        from er_model_lab.verbs.load import load, load_model

        with progress("diagnosing") as told:
            return diagnose(
                load(*data), load_model(model, effects_from or ()), held_out=loaded(hold_out), level=level,
                seed=seed, rule=Rule(false_alarm, smallest, helps), anyway=anyway, progress=told,
            )  # fmt: skip

    run(work, json_file, report, read=read_by(data, [model], effects_from, hold_out))


def add_command(
    effect: Annotated[
        str, typer.Argument(help="Effect of the catalogue; `lab effects` lists them.")
    ],
    data: Data,
    model: ModelFile,
    out: Out,
    json_file: Json = None,
    report: Report = None,
    hold_out: HoldOut = None,
    effects_from: EffectsFrom = None,
    level: Level = "damper",
    seed: Seed = 0,
    anyway: Anyway = False,
) -> None:
    """Add one effect, refit everything, and show the error before and after."""

    def work() -> Result:
        from er_model_lab.verbs.add import add
        from er_model_lab.verbs.load import load, load_model

        with progress(f"adding {effect}") as told:
            return add(
                load(*data), load_model(model, effects_from or ()), effect, name=out.stem,
                held_out=loaded(hold_out), level=level, seed=seed, anyway=anyway, progress=told,
            )  # fmt: skip

    run(work, json_file, report, out=out, read=read_by(data, [model], effects_from, hold_out))


def improve_command(
    data: Data,
    model: ModelFile,
    out: Out,
    json_file: Json = None,
    report: Report = None,
    hold_out: HoldOut = None,
    effects_from: EffectsFrom = None,
    level: Level = "damper",
    seed: Seed = 0,
    false_alarm: FalseAlarm = RULE.false_alarm,
    smallest: Smallest = RULE.smallest,
    helps: Helps = RULE.helps,
    anyway: Anyway = False,
    measured_terms: MeasuredTerms = False,
) -> None:
    """Diagnose and add, again and again, until the model is adequate or nothing known helps."""

    def work() -> Result:
        from er_model_lab.verbs.improve import improve
        from er_model_lab.verbs.load import load, load_model

        begun = load_model(model, effects_from or ())
        with progress("improving") as told:
            found = improve(
                load(*data), begun, name=out.stem, interrupted=_left(out, beside, effects_from),
                held_out=loaded(hold_out), level=level, seed=seed,
                rule=Rule(false_alarm, smallest, helps), anyway=anyway, progress=told,
                keep=keep, measured_terms=measured_terms,
            )  # fmt: skip
        return _with_effect_files(found, out)

    def keep(so_far: Model) -> None:
        from er_models.files import save_model

        with suppress(ErError, OSError):  # a full disk ends no search
            save_model(so_far, beside)

    beside = out.with_suffix(f".begun{out.suffix}")
    read = read_by(data, [model], effects_from, hold_out)
    run(work, json_file, report, out=out, read=read, beside=beside)


def _with_effect_files(result: Result, out: Path) -> Result:
    """The result once the formula of each measured term is written beside the new model, as an effect to begin with."""
    from er_models.files import write_whole

    terms = []
    for entry in result.view.result["measured_terms"]:
        file = out.with_suffix(f".{entry['name']}.py")
        if entry["effect_source"]:
            write_whole(file, entry["effect_source"])
        terms.append(entry | {"effect_file": str(file) if entry["effect_source"] else None})
    content = dict(result.view.result) | {"measured_terms": terms}
    return replace(result, view=replace(result.view, result=content))


def _left(out: Path, beside: Path, effects_from: list[Path] | None) -> Model | None:
    """What an earlier call left beside the new model, or in its place, where that is a model."""
    from er_model_lab.verbs.load import load_model

    for path in (beside, out):
        with suppress(ErError):
            if path.is_file():
                return load_model(path, effects_from or ())
    return None
