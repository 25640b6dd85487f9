"""Commands that look at measurements with a model as it is: check, compare; and identify."""

from __future__ import annotations

from dataclasses import replace
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
from er_model_lab.cli.running import asked, damper_only, read_by, run, working

if TYPE_CHECKING:
    from er_model_lab.verbs.ask import Outcome


def check(
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
    from er_model_lab.verbs import check as command

    outcome = run(
        lambda: command.run(data, model, tuple(effects_from or ())),
        json_file,
        report,
        read=read_by(data, [model] if model else (), effects_from),
        strict=False,
    )
    if outcome.result["verdict"] != "usable":
        raise typer.Exit(2)


def compare(
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
    from er_model_lab.verbs import compare as damper
    from er_model_lab.verbs import vehicle

    def work() -> Outcome:
        ask = asked(data, model[0], seed, hold_out, effects_from, level, anyway)
        ask = replace(ask, rivals=tuple(model[1:]))
        return vehicle.compare(ask) if level == "vehicle" else damper.compare(ask)

    run(work, json_file, report, read=read_by(data, model, effects_from, hold_out))


def identify(
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
    from er_model_lab.verbs import identify as command

    def work() -> Outcome:
        damper_only(level, "identify")
        with working("identifying") as how:
            return command.run(
                asked(data, model, seed, hold_out, effects_from, anyway=anyway), out, how
            )

    run(work, json_file, report, out, read=read_by(data, [model], effects_from, hold_out))
