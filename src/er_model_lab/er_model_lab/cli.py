"""Command line of the model lab: `er lab COMMAND`, or `er-lab COMMAND`."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from er_models.errors import ErError, InputError
from rich.console import Console

from er_model_lab.import_app import register
from er_model_lab.rule import RULE, Rule
from er_model_lab.thesis_app import register as register_thesis

if TYPE_CHECKING:
    from collections.abc import Iterator

    from er_model_lab.commands import Outcome, Request
    from er_model_lab.study import Tick

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    rich_markup_mode=None,
    help="Compare a damper model with measurements, find the missing effect, add it, watch the error fall.",
)
register(app)
register_thesis(app)

Data = Annotated[
    list[Path],
    typer.Argument(help="rosbag2 folder, .mcap, .csv, .parquet, .mf4, or a folder of them."),
]
ModelFile = Annotated[
    Path, typer.Option("--model", help="Model file (YAML), e.g. config/dampers/inove_guo.yaml.")
]
ModelFiles = Annotated[
    list[Path],
    typer.Option("--model", help="Model file (YAML); repeatable, further ones are set beside it."),
]
Json = Annotated[
    Path | None, typer.Option("--json", help="Write the machine-readable result here.")
]
Report = Annotated[
    Path | None,
    typer.Option("--report", help="Write a self-contained HTML report into this folder."),
]
Level = Annotated[
    str,
    typer.Option(
        help="damper: force from measured motion and duty; vehicle: motion from road and duty."
    ),
]
Seed = Annotated[int, typer.Option(help="Seed of everything random.")]
HoldOut = Annotated[
    list[Path] | None,
    typer.Option(
        "--hold-out", help="Data that only score: never used to fit or to choose. Repeatable."
    ),
]
Out = Annotated[Path, typer.Option("--out", help="New model file.")]
FalseAlarm = Annotated[
    float,
    typer.Option(
        "--false-alarm",
        help="Rate at which a complete model may be given a missing effect, above 0 and below 1.",
    ),
]
Smallest = Annotated[
    float,
    typer.Option(help="Effects smaller than this share of the noise are given no name."),
]
Anyway = Annotated[
    bool,
    typer.Option(
        "--anyway", help="Use data that fail the preflight all the same (exit status 3)."
    ),
]
EffectsFrom = Annotated[
    list[Path] | None,
    typer.Option("--effects-from", help="Python file with effects of your own. Repeatable."),
]


@app.command()
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
    from er_model_lab.preflight import command

    outcome = _run(
        lambda: command.run(data, model, tuple(effects_from or ())),
        json_file,
        report,
        strict=False,
    )
    if outcome.result["verdict"] != "usable":
        raise typer.Exit(2)


@app.command()
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
    from er_model_lab import commands, vehicle

    def work() -> Outcome:
        asked = _asked(data, model[0], seed, hold_out, effects_from, level, anyway)
        asked = replace(asked, rivals=tuple(model[1:]))
        return vehicle.compare(asked) if level == "vehicle" else commands.compare(asked)

    _run(work, json_file, report)


@app.command()
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
    anyway: Anyway = False,
) -> None:
    """Refit the model, then say which effect is missing, with evidence."""
    from er_model_lab import commands

    def work() -> Outcome:
        with _progress("trying effects", effects_from) as tick:
            asked = _asked(data, model, seed, hold_out, effects_from, level, anyway)
            return commands.diagnose(replace(asked, rule=Rule(false_alarm, smallest)), tick)

    _run(work, json_file, report)


@app.command()
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
    from er_model_lab import commands

    def work() -> Outcome:
        with _progress(f"adding {effect}", effects_from) as tick:
            return commands.add(
                _asked(data, model, seed, hold_out, effects_from, level, anyway), effect, out, tick
            )

    _run(work, json_file, report, out)


@app.command()
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
    anyway: Anyway = False,
) -> None:
    """Diagnose and add, again and again, until the model is adequate or nothing known helps."""
    from er_model_lab import commands

    def work() -> Outcome:
        with _progress("trying effects", effects_from) as tick:
            asked = _asked(data, model, seed, hold_out, effects_from, level, anyway)
            return commands.improve(replace(asked, rule=Rule(false_alarm, smallest)), out, tick)

    _run(work, json_file, report, out)


@app.command()
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
    from er_model_lab.identify import command

    def work() -> Outcome:
        _damper_only(level, "identify")
        with _stages("identifying", command.STEPS) as tick:
            return command.run(
                _asked(data, model, seed, hold_out, effects_from, anyway=anyway), out, tick
            )

    _run(work, json_file, report, out)


@app.command()
def plan(
    model: ModelFile,
    between: Annotated[
        tuple[str, str] | None, typer.Option(help="Two effects to tell apart.")
    ] = None,
    reveal: Annotated[
        str | None, typer.Option(help="One effect to tell from its absence.")
    ] = None,
    data: Annotated[
        list[Path] | None,
        typer.Option(
            "--data", help="What is already measured; effects as fitted to it. Repeatable."
        ),
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", help="Program file to write.")] = None,
    vehicle: Annotated[
        Path | None, typer.Option(help="Vehicle file, where the model is a damper alone.")
    ] = None,
    stroke: Annotated[
        float | None, typer.Option(help="Largest |deflection| [m]; else the model's rig.")
    ] = None,
    velocity: Annotated[
        float | None,
        typer.Option(help="Largest |deflection velocity| [m/s]; else the model's rig."),
    ] = None,
    duty_max: Annotated[
        float | None, typer.Option(help="Largest duty; else the model's rig.")
    ] = None,
    duration: Annotated[float | None, typer.Option(help="Length of the program [s]; 30.")] = None,
    json_file: Json = None,
    report: Report = None,
    effects_from: EffectsFrom = None,
    level: Level = "damper",
    seed: Seed = 0,
) -> None:
    """The road and duty that would tell two effects apart best, within the rig's limits."""
    from er_model_lab.plan import command
    from er_model_lab.plan.limits import Asked

    def work() -> Outcome:
        _damper_only(level, "plan")
        limits = Asked(stroke, velocity, duty_max, duration)
        wanted = command.Wanted(between or (), reveal, vehicle, limits, out)
        with _stages("planning", command.STEPS) as tick:
            return command.run(_asked(data or [], model, seed, None, effects_from), wanted, tick)

    _run(work, json_file, report)


@app.command()
def effects(
    effect: Annotated[str | None, typer.Argument(help="Show the card of this effect.")] = None,
    json_file: Json = None,
    effects_from: EffectsFrom = None,
) -> None:
    """The catalogue of effects, or the card of one."""
    from er_models.own import catalogue_with

    from er_model_lab.effects_command import card, table

    try:
        catalogue = catalogue_with(effects_from or ())
        result, text = card(effect, catalogue) if effect else table(catalogue)
        _write_json(json_file, result)
        _console().print(text, soft_wrap=bool(effect))
    except ErError as error:
        _fail(error)


def _asked(
    data: list[Path],
    model: Path,
    seed: int,
    hold_out: list[Path] | None,
    effects_from: list[Path] | None,
    level: str = "damper",
    anyway: bool = False,
) -> Request:
    """The request of a command line."""
    from er_model_lab.commands import Request

    if level not in ("damper", "vehicle"):
        raise InputError("--level", "", "damper or vehicle", level)
    return Request(
        data,
        model,
        seed,
        tuple(hold_out or ()),
        tuple(effects_from or ()),
        level=level,
        anyway=anyway,
    )


def _damper_only(level: str, command: str) -> None:
    """Levels other than damper are refused in words."""
    if level == "vehicle":
        raise InputError(
            "--level", "", f"damper (lab {command} works on the damper force)", "vehicle"
        )
    if level != "damper":
        raise InputError("--level", "", "damper or vehicle", level)


def _run(
    work: Callable[[], Outcome],
    json_file: Path | None,
    report: Path | None,
    out: Path | None = None,
    *,
    strict: bool = True,
) -> Outcome:
    """Do the work, write what was asked for, print one screen, and exit with the contract's status."""
    try:
        outcome = work()
        _write_json(json_file, outcome.result)
        page = _write_report(report, outcome)
        _print(outcome, page, out)
    except ErError as error:
        _fail(error)
    except KeyboardInterrupt:
        typer.echo("interrupted: nothing was written", err=True)
        raise typer.Exit(130) from None
    if outcome.interrupted:
        typer.echo(
            "interrupted: what was done is written; the same command goes on from there", err=True
        )
        raise typer.Exit(130)
    if strict and not outcome.complete:
        typer.echo("the data were incomplete: see the notes", err=True)
        raise typer.Exit(3)
    return outcome


def _print(outcome: Outcome, page: Path | None, out: Path | None) -> None:
    """One screen of summary."""
    from er_model_lab.terminal import summary

    _console().print(summary(outcome.view))
    if out:
        typer.echo(f"new model: {out}")
    if page:
        typer.echo(f"report: {page}")


def _console() -> Console:
    """The terminal; a file or pipe is 100 columns wide."""
    return Console() if sys.stdout.isatty() else Console(width=100)


def _write_report(folder: Path | None, outcome: Outcome) -> Path | None:
    """The HTML report, when asked for."""
    if folder is None:
        return None
    from er_model_lab.report.page import write_report

    return write_report(outcome.view, folder)


def _write_json(path: Path | None, result: Any) -> None:
    """The result as JSON, whole or not at all."""
    if path is not None:
        from er_models.files import write_whole

        write_whole(path, json.dumps(result, indent=1, allow_nan=False) + "\n")


def _fail(error: ErError) -> None:
    """One clear line and the error's exit status."""
    typer.echo(" ".join(str(error).split()), err=True)
    raise typer.Exit(error.exit_status) from None


@contextmanager
def _progress(title: str, effects_from: list[Path] | None) -> Iterator[Tick | None]:
    """A progress bar with the effect being tried, on a terminal only."""
    from er_models.own import catalogue_with

    total = len(catalogue_with(effects_from or ()).candidates()) if sys.stderr.isatty() else 0
    with _stages(title, total) as tick:
        yield tick


@contextmanager
def _stages(title: str, total: int) -> Iterator[Tick | None]:
    """A progress bar with what is being done, on a terminal only."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=total)
        done = [0]

        def tick(now: str) -> None:
            done[0] += 1
            if done[0] > total:
                done[0] = 1
            bar.update(task, completed=done[0], description=f"{title}: {now}")

        yield tick


def main() -> None:
    """Entry point; `-h` works everywhere."""
    app()


if __name__ == "__main__":
    main()
