"""`lab fleet`: many dampers on Dask."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from er_model_lab.cli.options import (
    Anyway,
    EffectsFrom,
    FalseAlarm,
    Helps,
    Json,
    Level,
    ModelFile,
    Report,
    Seed,
    Smallest,
)
from er_model_lab.cli.running import damper_only, progress, run
from er_model_lab.diagnosis.rule import RULE, Rule

if TYPE_CHECKING:
    from er_model_lab.results.result import Result


def fleet_command(
    data: Annotated[
        list[str],
        typer.Argument(
            metavar="DATA",
            help="Folders, globs, URLs, or tables (CSV, Parquet) with a column path.",
        ),
    ],
    model: ModelFile,
    out: Annotated[Path, typer.Option("--out", help="Table to write, one row a unit (.parquet).")],
    by: Annotated[
        str | None,
        typer.Option(
            help="What names a unit: folder, file, namespace, or a column of the table (else: unit, folder)."
        ),
    ] = None,
    search: Annotated[
        bool,
        typer.Option(
            "--search/--no-search",
            help="Search for effects, or only refit.",
        ),
    ] = True,
    resume: Annotated[
        bool,
        typer.Option("--resume", help="Go on from what an earlier run kept; nothing is repeated."),
    ] = False,
    cluster: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS",
            help="Dask scheduler (tcp:// or tls://); else processes of this machine.",
        ),
    ] = None,
    workers: Annotated[
        int | None, typer.Option(help="Processes of this machine; else one for each core.", min=1)
    ] = None,
    most: Annotated[
        int, typer.Option(help="Recordings that a unit is diagnosed with, at most.", min=1)
    ] = 20,
    json_file: Json = None,
    report: Report = None,
    effects_from: EffectsFrom = None,
    level: Level = "damper",
    seed: Seed = 0,
    false_alarm: FalseAlarm = RULE.false_alarm,
    smallest: Smallest = RULE.smallest,
    helps: Helps = RULE.helps,
    anyway: Anyway = False,
) -> None:
    """Diagnose many dampers, and say which differ, in what, and since when."""

    def work() -> Result:
        damper_only(level, "fleet")
        from er_model_lab.fleets.fleet import fleet
        from er_model_lab.verbs.load import load_model

        if cluster is not None and cluster.startswith("tcp://"):
            typer.echo(
                f"{cluster} is not encrypted: whoever is that scheduler can run programs as you",
                err=True,
            )
        with progress("fleet") as told:
            return fleet(
                data, load_model(model, effects_from or ()), out=out, by=by, search=search, resume=resume,
                cluster=cluster, workers=workers, most=most, seed=seed, rule=Rule(false_alarm, smallest, helps),
                anyway=anyway, progress=told, reports=10 if report else 0,
            )  # fmt: skip

    read = {
        "DATA": [Path(d) for d in data if Path(d).exists()],
        "--model": [model],
        "--effects-from": effects_from or (),
    }
    run(work, json_file, report, read=read, table=out)
