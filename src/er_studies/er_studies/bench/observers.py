"""``er bench observers``: what one step of each observer costs, beside the Kalman filters, in the same run."""

from __future__ import annotations

import time
import tracemalloc
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import typer
from er_models.files import load_model
from er_models.model import Array, Model
from er_observers.running.runtime import Sample

from er_studies.bench.machine import machine
from er_studies.given_out import Json, Table, give
from er_studies.observers.estimators import Estimator, estimators_of
from er_studies.observers.scenarios.drive import drive
from er_studies.observers.scenarios.files import choose_scenarios, load_scenarios
from er_studies.observers.scenarios.scenario import Scenario
from er_studies.programs import program_of, run

_WARM = 200


class Cost(NamedTuple):
    """Of one estimator: times per step (n,) [s], bytes that stay allocated after a thousand steps."""

    title: str
    seconds: Array
    kept: int


def measure(estimator: Estimator, samples: list[Sample]) -> Cost:
    """Step through the samples; the first are not counted."""
    p, step = estimator.parameters, estimator.step
    state, seconds = estimator.start(p, samples[0], None), []
    for sample in samples[1:]:
        begun = time.perf_counter()
        state, _ = step(p, state, sample)
        seconds.append(time.perf_counter() - begun)
    tracemalloc.start()
    state = estimator.start(p, samples[0], None)
    state, _ = step(p, state, samples[1])
    before = tracemalloc.get_traced_memory()[0]
    for sample in samples[2:1002]:
        state, _ = step(p, state, sample)
    kept = tracemalloc.get_traced_memory()[0] - before
    tracemalloc.stop()
    return Cost(estimator.title, np.array(seconds[_WARM:]), max(0, kept))


def table(title: str, costs: list[Cost]) -> Table:
    """Costs for people; ratios of medians to the extended Kalman filter."""
    base = next((c for c in costs if "xtended" in c.title), costs[-1])
    rows = []
    for c in costs:
        numbers = [f"{1e6 * v:.1f}" for v in np.percentile(c.seconds, [50, 99, 99.9])]
        ratio = float(np.median(c.seconds) / np.median(base.seconds))
        rows.append((c.title, *numbers, f"{ratio:.2f}", str(c.kept)))
    head = ("estimator", "median", "99 %", "99.9 %", f"median / {base.title}", "kept [B]")
    return Table(head, rows, f"one step, Python included [us]: {title}")


def samples_of(scenario: Scenario, car: Model, jitter: float) -> list[Sample]:
    """What the estimators are told along a scenario; jitter: standard deviation of the stamps [s]."""
    record = drive(scenario, car)
    shaken = {
        **record,
        "t": record["t"] + np.random.default_rng(0).normal(0.0, jitter, record["t"].shape),
    }
    names = ("t", "told_sprung_acceleration", "told_unsprung_acceleration", "told_duty")
    return [Sample(*row) for row in zip(*(shaken[n].tolist() for n in names), strict=True)]


def main(
    config: Annotated[
        Path, typer.Option(help="Folder with vehicles, gains and scenarios.")
    ] = Path("config"),
    scenario: Annotated[
        list[str] | None, typer.Option(help="Drive to step through, again for more.")
    ] = None,
    repeat: Annotated[int, typer.Option(min=1, help="Repetitions of each drive.")] = 5,
    jitter: Annotated[float, typer.Option(min=0.0, help="Jitter of the time stamps [us].")] = 0.0,
    json_file: Json = None,
) -> None:
    """Time every step of the observers and their peers along drives.

    By default one whose duty switches between two values, and one whose duty changes with every sample.
    """
    car = load_model(config / "vehicles" / "inove_quarter_car.yaml")
    known, tables = load_scenarios(config / "scenarios"), []
    for chosen in choose_scenarios(known, scenario or ["chapter_5_noise", "chapter_4_slow_duty"]):
        samples, estimators = (
            samples_of(chosen, car, 1e-6 * jitter),
            estimators_of(car, config / "gains"),
        )
        runs = [[measure(each, samples) for each in estimators] for _ in range(repeat)]
        best = [
            min(each, key=lambda run: float(np.median(run.seconds)))
            for each in zip(*runs, strict=True)
        ]
        tables.append(table(chosen.name, best))
    give([*tables, machine()], json_file)


app = program_of(main)

if __name__ == "__main__":
    run(app)
