"""``er bench observers``: what one step of each observer costs, beside the Kalman filters, in the same run."""

from __future__ import annotations

import time
import tracemalloc
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import typer
from er_models.files import load_model
from er_models.model import Array
from rich.console import Console
from rich.table import Table

from er_observers.compare.estimators import Estimator, estimators_of
from er_observers.observers.runtime import Sample
from er_observers.scenarios.drive import drive
from er_observers.scenarios.files import choose_scenarios, load_scenarios

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


def table(costs: list[Cost]) -> Table:
    """Costs for people; ratios of medians to the extended Kalman filter."""
    base = next((c for c in costs if "xtended" in c.title), costs[-1])
    shown = Table(title="one step, Python included [us]")
    shown.add_column("estimator")
    for name in ("median", "99 %", "99.9 %", f"median / {base.title}", "kept [B]"):
        shown.add_column(name, justify="right")
    for c in costs:
        numbers = [f"{1e6 * v:.1f}" for v in np.percentile(c.seconds, [50, 99, 99.9])]
        ratio = float(np.median(c.seconds) / np.median(base.seconds))
        shown.add_row(c.title, *numbers, f"{ratio:.2f}", str(c.kept))
    return shown


def main(
    config: Annotated[
        Path, typer.Option(help="Folder with vehicles, gains and scenarios.")
    ] = Path("config"),
    scenario: Annotated[str, typer.Option(help="Drive to step through.")] = "chapter_5_noise",
    repeat: Annotated[int, typer.Option(min=1, help="How often.")] = 3,
) -> None:
    """Time every step of the observers and their peers along a drive."""
    car = load_model(config / "vehicles" / "inove_quarter_car.yaml")
    (chosen,) = choose_scenarios(load_scenarios(config / "scenarios"), [scenario])
    record = drive(chosen, car)
    names = ("t", "told_sprung_acceleration", "told_unsprung_acceleration", "told_duty")
    samples = [Sample(*row) for row in zip(*(record[n].tolist() for n in names), strict=True)]
    costs = []
    for estimator in estimators_of(car, config / "gains"):
        runs = [measure(estimator, samples) for _ in range(repeat)]
        costs.append(min(runs, key=lambda run: float(np.median(run.seconds))))
    Console().print(table(costs))


if __name__ == "__main__":
    typer.run(main)
