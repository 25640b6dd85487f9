"""From force to duty, measured: inverse static model against the inner loop, with right and wrong parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from er_models.constants import SAMPLE_TIME as DT
from er_models.model import Array, Model
from numpy.typing import NDArray

from er_studies.control.closed_loop import Sensors, drive, known
from er_studies.control.measures import weighted
from er_studies.control.run import Setup
from er_studies.control.scenarios import Scenario

BASE: Mapping[str, Any] = {"feedback": "deflection", "horizon": 0.01, "dead_zone": 0.05}
"""What all ways have in common where they do not say otherwise, beside the shipped parameters."""
VARIANTS: Mapping[str, Mapping[str, Any]] = {
    "inverse static model": {"horizon": 0.0, "least_gate": 0.0, "ahead": 0.0},
    "the same, with least_gate and ahead": {"horizon": 0.0},
    "loop, 5 ms": {"horizon": 0.005},
    "loop, 10 ms": {},
    "loop, 20 ms": {"horizon": 0.02},
    "10 ms, ahead 0": {"ahead": 0.0},
    "10 ms, least_gate 0": {"least_gate": 0.0},
    "10 ms, correction 0.3": {"correction": 0.3},
    "10 ms, correction 1": {"correction": 1.0},
    "10 ms, slew 20 1/s": {"slew": 20.0},
    "10 ms, dead zone 0": {"dead_zone": 0.0},
}
"""Changes of that."""
CARS: Mapping[str, Mapping[tuple[str, str], float]] = {
    "as believed": {},
    "tau 30 % longer": {("response", "tau"): 1.3},
    "yield force 20 % smaller": {("guo_yield", "f_c"): 0.8},
}
"""Factors of the true car's parameters."""


class Row(NamedTuple):
    """A way on a car: force error, rms [N]; travel of the duty [1/s]; deflection, rms [m]; comfort [m/s2]."""

    way: str
    car: str
    error: float
    travel: float
    rms: float
    comfort: float


def rows(
    setup: Setup, scenario: Scenario, fault: str, seeds: int, tick: Callable[[str], None] | None = None
) -> list[Row]:  # fmt: skip
    """Every way on every car, means over the first roads of a scenario, the fault known."""
    found = []
    for name, changes in VARIANTS.items():
        for car in CARS:
            if tick is not None:
                tick(f"{name}, {car}")
            each = [_one(setup, scenario, fault, changes, CARS[car], k) for k in range(seeds)]
            found.append(Row(name, car, *np.mean(each, axis=0).tolist()))
    return found


def markdown(found: list[Row]) -> str:
    """The rows as a table."""
    lines = [
        "| from force to duty | car | force error [N] | travel of duty [1/s] | deflection rms [mm] | comfort [m/s2] |",
        "|---|---|---|---|---|---|",
    ]
    for r in found:
        numbers = f"{r.error:.3f} | {r.travel:.1f} | {1e3 * r.rms:.3f} | {r.comfort:.3f}"
        lines.append(f"| {r.way} | {r.car} | {numbers} |")
    return "\n".join(lines)


def _one(
    setup: Setup, scenario: Scenario, fault: str, changes: Mapping[str, Any],
    factors: Mapping[tuple[str, str], float], number: int,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Figures of one run."""
    limits: dict[str, Any] = {"u_max": scenario.duty_max, "latency": scenario.latency * DT}
    p = replace(setup.parameters, **limits, **{**BASE, **changes})
    car = _changed(scenario.car(setup.model, fault), factors)
    road, seed = scenario.road(setup.model, number), scenario.program.seed + number
    sensors = Sensors(latency=scenario.latency)
    record = drive(car, road, DT, setup.built(p), known(setup.model, car), sensors, seed)
    t = record["t"]
    rows = (t >= scenario.window[0] - 1e-9) & (t <= scenario.window[1] + 1e-9)
    return (*_tracking(record, rows), *_felt(record, rows))


def _tracking(record: Mapping[str, Array], rows: NDArray[np.bool_]) -> tuple[float, float]:
    """Force given against that made one sample later, where its duty has acted; travel of the duty."""
    made, given = record["damper_force"][1:], record["given"][:-1]
    error = float(np.sqrt(np.mean((made - given)[rows[1:]] ** 2)))
    travel = np.abs(np.diff(record["duty"][rows])).sum() / (np.ptp(record["t"][rows]))
    return error, float(travel)


def _felt(record: Mapping[str, Array], rows: NDArray[np.bool_]) -> tuple[float, float]:
    """Deflection and weighted acceleration, rms."""
    felt = weighted(record["sprung_acceleration"], DT)[rows]
    return float(np.sqrt(np.mean(record["deflection"][rows] ** 2))), float(
        np.sqrt(np.mean(felt**2))
    )


def _changed(model: Model, factors: Mapping[tuple[str, str], float]) -> Model:
    """The car with some parameters multiplied."""
    effects = {name: dict(values) for name, values in model.effects.items()}
    for (effect, parameter), factor in factors.items():
        effects[effect][parameter] *= factor
    return replace(model, effects=effects)
