"""`lab export`: a model, and what it makes of data, for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from er_models.errors import ErError, InputError
from er_models.one_line import INTERRUPTED

from er_model_lab.cli.options import Anyway, EffectsFrom, Json, Level, ModelFile, Report, Seed
from er_model_lab.cli.places import writable
from er_model_lab.cli.running import damper_only, fail, loaded, read_by, write_json

if TYPE_CHECKING:
    from er_model_lab.verbs.export import ExportResult


def export_command(
    model: ModelFile,
    data: Annotated[
        list[Path] | None,
        typer.Argument(metavar="[DATA]", help="Measurements, for --series alone."),
    ] = None,
    series: Annotated[
        Path | None,
        typer.Option(
            "--series",
            metavar="OUT",
            help="Time, inputs, measured, predicted, residual and each effect's share: .csv, .parquet, .mat or .mf4, "
            "one file a record.",
        ),
    ] = None,
    lut: Annotated[
        Path | None,
        typer.Option(
            "--lut", metavar="OUT", help="Force over velocity and duty as a table: .csv."
        ),
    ] = None,
    c: Annotated[
        Path | None, typer.Option("--c", metavar="DIR", help="The damper as C code.")
    ] = None,
    fmu: Annotated[
        Path | None,
        typer.Option("--fmu", metavar="OUT", help="The damper as FMI co-simulation unit: .fmu."),
    ] = None,
    fmi: Annotated[int, typer.Option(help="Version of FMI: 2 or 3.")] = 3,
    sensors: Annotated[
        bool,
        typer.Option(
            "--sensors/--no-sensors",
            help="Whether C code and FMU hold what the sensors do to motion and force.",
        ),
    ] = True,
    json_file: Json = None,
    report: Report = None,
    effects_from: EffectsFrom = None,
    level: Level = "damper",
    seed: Seed = 0,
    anyway: Anyway = False,
) -> None:
    """Take a model to other programs: its force along data, a table of it, C code, an FMU.

    The report is that of compare.
    """
    try:
        damper_only(level, "export")
        for what, given in (("DATA", data), ("report", report)):
            if given and series is None:
                raise InputError(what, "", "--series with it", "none")
        files = {"--series": series, "--lut": lut, "--fmu": fmu, "--json": json_file}
        writable(files, report, read_by(data, [model], effects_from))
        from er_model_lab.verbs.export import export
        from er_model_lab.verbs.load import load_model

        taken, measured = load_model(model, effects_from or ()), loaded(data)
        result = export(
            taken, measured, series=series, lut=lut, c=c, fmu=fmu, fmi=fmi,
            sensors=sensors, anyway=anyway,
        )  # fmt: skip
        write_json(json_file, result.to_dict() | {"seed": seed})
        if report is not None and measured is not None:
            from er_model_lab.verbs.compare import compare

            page = compare(measured, taken, seed=seed, anyway=anyway).report(report)
    except ErError as error:
        fail(error)
    except KeyboardInterrupt:
        typer.echo("interrupted: what was finished is written", err=True)
        raise typer.Exit(INTERRUPTED) from None
    _print(result)
    if report is not None:
        typer.echo(f"report: {page}")
    if not result.complete:
        typer.echo("the data were incomplete: see the notes", err=True)
        raise typer.Exit(3)


def _print(result: ExportResult) -> None:
    """What was written, and what to know of it."""
    from er_model_lab.output.text.units import newtons

    for each in result.content.get("series", ()):
        shares = sorted(each["shares"].items(), key=lambda item: -item[1])
        largest = ", ".join(f"{name} {newtons(size)}" for name, size in shares[:4])
        typer.echo(
            f"{each['record']}: {each['rows']} rows, error {newtons(each['rmse'])}; without {largest}"
        )
    for path in result.files:
        typer.echo(f"written: {path}")
    for note in result.notes:
        typer.echo(f"note: {note}")
