"""``er study classes``: observers with and without deflection sensor beside the peers, ISO roads A to E."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from er_models.files import load_model, write_json
from er_models.model import Array, Model
from er_models.places import writable
from numpy.typing import NDArray

from er_studies.given_out import Json
from er_studies.observers.classes import CASES, CLASSES, MICROMETRES, scenario, with_noise
from er_studies.observers.estimators import Estimator, estimators_of
from er_studies.observers.nrmse import nrmse
from er_studies.observers.peers.known import tuned_peers
from er_studies.observers.run import follow
from er_studies.observers.scenarios.drive import drive
from er_studies.programs import program_of, run
from er_studies.progress import progress_of

USUAL = 20
"""Noise [um] at which everything is compared; at the others only what uses the sensor."""
_ALONE = "alone"


def columns(model: Model, config: Path) -> tuple[Estimator, ...]:
    """Every observer without the sensor, the fused one, the peers."""
    ours = [e for e in estimators_of(model, config / "gains") if e.ours]
    alone = [
        replace(e, parameters=replace(e.parameters, sensors=None), name=f"{e.name}_{_ALONE}")
        for e in ours
    ]
    fused = replace(ours[-1], name="fused", title="with the sensor")
    return (fused, *alone, *tuned_peers(model, config / "peers.yaml"))


def errors_of(
    columns: Sequence[Estimator],
    road_class: str,
    case: str,
    micrometres: int,
    model: Model,
    seeds: int,
) -> dict[str, float]:
    """Median NRMSE of each column over the roads, by name; those without the sensor at the usual noise only."""
    found: dict[str, list[float]] = {}
    for k in range(seeds):
        s = with_noise(scenario(road_class, case), micrometres)
        record = drive(s, model, k)
        rows = record["t"] >= s.windows[0].begin
        for e in columns:
            if micrometres == USUAL or e.name in ("fused", "balance", "momentum", "horizon"):
                found.setdefault(e.name, []).append(_error(e, record, rows))
    return {name: float(np.median(v)) for name, v in found.items()}


def _error(e: Estimator, record: dict[str, Array], rows: NDArray[np.bool_]) -> float:
    """NRMSE of one column on one record."""
    return nrmse(record["damper_force"][rows], follow(e, record, None).force[rows])


def table(found: dict[str, dict[str, float]], names: Sequence[str]) -> str:
    """The errors in % as a table in Markdown; the last column: fused over the best of all others there."""
    lines = [
        "| drive | " + " | ".join(names) + " | fused / best |",
        "|---" * (len(names) + 2) + "|",
    ]
    for drive_name, errors in found.items():
        others = [v for n, v in errors.items() if n != "fused"]
        cells = [f"{100 * errors[n]:.3f}" if n in errors else "" for n in names]
        lines.append(
            f"| {drive_name} | {' | '.join(cells)} | {errors['fused'] / min(others):.2f} |"
        )
    return "\n".join(lines) + "\n"


def main(
    config: Annotated[Path, typer.Option(help="Folder with vehicles, gains, peers.")] = Path(
        "config"
    ),
    seeds: Annotated[int, typer.Option(min=1, help="Roads of each drive.")] = 1,
    classes: Annotated[str, typer.Option(help="Classes of road.")] = CLASSES,
    case: Annotated[
        list[str] | None, typer.Option(help="Case, again for more; all by default.")
    ] = None,
    noise: Annotated[list[int] | None, typer.Option(help="Noise of the deflection [um].")] = None,
    json_file: Json = None,
) -> None:
    """Compare on roads that are scored and not tuned on; a table in Markdown."""
    writable({"--json": json_file}, None, {})
    car = load_model(config / "vehicles" / "inove_quarter_car.yaml")
    made, found = columns(car, config), {}
    jobs = [(n, c, k) for n in noise or MICROMETRES for c in classes for k in case or CASES]
    with progress_of("drives") as tick:
        for done, (n, c, k) in enumerate(jobs, start=1):
            found[f"{n} um, {c}, {k}"] = errors_of(made, c, k, n, car, seeds)
            if tick is not None:
                tick(done, len(jobs))
    typer.echo(table(found, [e.name for e in made]), nl=False)
    write_json(json_file, found)


app = program_of(main)

if __name__ == "__main__":
    run(app)
