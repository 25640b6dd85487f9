"""`./er study observers`: all scenarios, all observers, the peers, the thesis's tables."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer
from er_models.files import load_model, write_json, write_whole
from er_models.model import Model
from er_models.places import writable
from rich.console import Console

from er_studies.given_out import Json
from er_studies.observers.estimators import Estimator, estimators_of
from er_studies.observers.run import compare, follow
from er_studies.observers.scenarios.drive import drive
from er_studies.observers.scenarios.files import choose_scenarios, load_scenarios
from er_studies.observers.scenarios.scenario import Scenario
from er_studies.observers.scenarios.starts import first_state
from er_studies.observers.table import csv_lines, document
from er_studies.observers.terminal import tables
from er_studies.programs import program_of, run
from er_studies.progress import progress_of

_WIDTH = 200
Folder = Annotated[Path, typer.Option(help="Folder with vehicles, gains and scenarios.")]


def observers_command(
    only: Annotated[
        list[str] | None, typer.Argument(help="Scenarios or their files; all by default.")
    ] = None,
    config: Folder = Path("config"),
    model: Annotated[
        Path | None, typer.Option(help="Vehicle model that the observers believe in.")
    ] = None,
    gains: Annotated[
        Path | None,
        typer.Option(help="Folder with gain files; that of the configuration by default."),
    ] = None,
    seeds: Annotated[
        int | None,
        typer.Option(
            min=1, help="Number of random roads per scenario; all of its own by default."
        ),
    ] = None,
    json_file: Json = None,
    csv_file: Annotated[
        Path | None, typer.Option("--csv", help="Write every road and window here.")
    ] = None,
    pictures: Annotated[
        Path | None, typer.Option(help="Draw force and error of each scenario's first road here.")
    ] = None,
) -> None:
    """Compare the observers with Kalman filters on named drives, beside the figures of the thesis."""
    believed = model or config / "vehicles" / "inove_quarter_car.yaml"
    writable({"--json": json_file, "--csv": csv_file}, pictures, {"--model": (believed,)})
    car = load_model(believed)
    gains = gains or config / "gains"
    estimators = estimators_of(car, gains)
    scenarios = choose_scenarios(load_scenarios(config / "scenarios"), only or [])
    with progress_of("roads") as tick:
        outcomes = compare(scenarios, car, gains, seeds, tick)
    titles = {e.name: e.title for e in estimators}
    ours = [e.name for e in estimators if e.ours]
    console = Console(width=None if sys.stdout.isatty() else _WIDTH)
    for table in tables(scenarios, outcomes, titles, ours):
        console.print(table)
    write_json(json_file, document(scenarios, outcomes, titles, ours))
    if csv_file is not None:
        write_whole(csv_file, "\n".join(csv_lines(scenarios, outcomes)) + "\n")
    if pictures is not None:
        _draw(pictures, scenarios, car, estimators)
        console.print(f"pictures: {pictures}", soft_wrap=True)


def _draw(
    folder: Path, scenarios: Sequence[Scenario], car: Model, estimators: Sequence[Estimator]
) -> None:
    """The first road of each scenario as a picture."""
    from er_studies.observers.report.pictures import draw

    folder.mkdir(parents=True, exist_ok=True)
    for s in scenarios:
        record = drive(s, car)
        forces = {
            e.title: follow(e, record, first_state(s, e.form, e.name, record)).force
            for e in estimators
        }
        draw(folder / f"{s.name.replace('/', '_')}.png", s.title, record, forces)


app = program_of(observers_command)

if __name__ == "__main__":
    run(app)
