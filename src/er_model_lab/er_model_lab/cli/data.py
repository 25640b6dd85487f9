"""Commands that look at measurements with a model as it is: check, compare; and identify."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from er_model_lab.cli.options import (
    Anyway,
    Data,
    EffectsFrom,
    HoldOut,
    Json,
    Level,
    ModelFile,
    ModelFiles,
    Out,
    Report,
    Seed,
)
from er_model_lab.cli.running import damper_only, loaded, progress, read_by, run

if TYPE_CHECKING:
    from er_model_lab.results.result import Result


def check_command(
    data: Data,
    model: Annotated[
        Path | None,
        typer.Option("--model", help="Model whose rig says how far the data could reach."),
    ] = None,
    json_file: Json = None,
    report: Report = None,
    effects_from: EffectsFrom = None,
) -> None:
    """Check measurements before anything is fitted: sampling, clipping, units, clocks, and what they cover."""

    def work() -> Result:
        from er_model_lab.verbs.check import check
        from er_model_lab.verbs.load import load, load_model

        return check(load(*data), load_model(model, effects_from or ()) if model else None)

    read = read_by(data, [model] if model else (), effects_from)
    result = run(work, json_file, report, read=read, strict=False)
    if result.view.result["verdict"] != "usable":
        raise typer.Exit(2)


def compare_command(
    data: Data,
    model: ModelFiles,
    json_file: Json = None,
    report: Report = None,
    hold_out: HoldOut = None,
    effects_from: EffectsFrom = None,
    level: Level = "damper",
    seed: Seed = 0,
    anyway: Anyway = False,
) -> None:
    """Predict and compare: errors, and where the model fails; several models side by side."""

    def work() -> Result:
        from er_model_lab.verbs.compare import compare
        from er_model_lab.verbs.load import load, load_model

        models = [load_model(file, effects_from or ()) for file in model]
        return compare(
            load(*data), *models, held_out=loaded(hold_out), level=level, seed=seed, anyway=anyway
        )

    run(work, json_file, report, read=read_by(data, model, effects_from, hold_out))


def identify_command(
    data: Data,
    model: ModelFile,
    out: Out,
    json_file: Json = None,
    report: Report = None,
    hold_out: HoldOut = None,
    level: Level = "damper",
    seed: Seed = 0,
    effects_from: EffectsFrom = None,
    anyway: Anyway = False,
) -> None:
    """Identify every parameter in stages, as in chapter 1 of the thesis, and say what the data cannot tell."""

    def work() -> Result:
        damper_only(level, "identify")
        from er_model_lab.verbs.identify import identify
        from er_model_lab.verbs.load import load, load_model

        with progress("identifying") as told:
            return identify(
                load(*data), load_model(model, effects_from or ()), name=out.stem,
                held_out=loaded(hold_out), seed=seed, anyway=anyway, progress=told,
            )  # fmt: skip

    run(work, json_file, report, out=out, read=read_by(data, [model], effects_from, hold_out))
