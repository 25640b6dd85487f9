"""Commands that look for what a model lacks: diagnose, add, improve."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

import typer

from er_model_lab.cli.options import (
    Anyway,
    Data,
    EffectsFrom,
    FalseAlarm,
    Helps,
    HoldOut,
    Json,
    Level,
    ModelFile,
    Out,
    Report,
    Seed,
    Smallest,
)
from er_model_lab.cli.running import asked, read_by, run, working
from er_model_lab.diagnosis.rule import RULE, Rule

if TYPE_CHECKING:
    from er_model_lab.verbs.ask import Outcome


def diagnose(
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
    from er_model_lab.verbs import diagnose as command

    def work() -> Outcome:
        with working("diagnosing") as how:
            ask = asked(data, model, seed, hold_out, effects_from, level, anyway)
            return command.diagnose(replace(ask, rule=Rule(false_alarm, smallest, helps)), how)

    run(work, json_file, report, read=read_by(data, [model], effects_from, hold_out))


def add(
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
    from er_model_lab.verbs import add as command

    def work() -> Outcome:
        with working(f"adding {effect}") as how:
            return command.add(
                asked(data, model, seed, hold_out, effects_from, level, anyway), effect, out, how
            )

    run(work, json_file, report, out, read=read_by(data, [model], effects_from, hold_out))


def improve(
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
) -> None:
    """Diagnose and add, again and again, until the model is adequate or nothing known helps."""
    from er_model_lab.verbs import improve as command

    def work() -> Outcome:
        with working("improving") as how:
            ask = asked(data, model, seed, hold_out, effects_from, level, anyway)
            return command.improve(replace(ask, rule=Rule(false_alarm, smallest, helps)), out, how)

    run(work, json_file, report, out, read=read_by(data, [model], effects_from, hold_out))
