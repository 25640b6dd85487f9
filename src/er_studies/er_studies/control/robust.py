"""The loop with the fault estimator in it, where the car is another than believed and samples come late or never."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from er_models.constants import SAMPLE_TIME as DT
from er_models.model import Array, Model

from er_studies.control import contest
from er_studies.control.closed_loop import Sensors, Watch, drive
from er_studies.control.estimated import estimated
from er_studies.control.measures import weighted
from er_studies.control.rivals import passive
from er_studies.control.run import Setup

BEGIN = 6.0
"""Counting begins when the leak, which appears at 1 s, has been there for five [s]."""


class Case(NamedTuple):
    """Sprung mass over the believed one; latency in samples, which nobody is told; share of samples lost."""

    mass: float = 1.0
    latency: int = 0
    lost: float = 0.0


CASES: Mapping[str, Case] = {
    "as believed": Case(), "mass -10 %": Case(0.9), "mass +20 %": Case(1.2), "mass +30 %": Case(1.3),
    "one sample late": Case(latency=1), "two samples late": Case(latency=2), "5 % of samples lost": Case(lost=0.05),
    "mass +20 %, one late, 5 % lost": Case(1.2, 1, 0.05),
}  # fmt: skip


def rows(
    setup: Setup, seeds: int, constant: float, tick: Callable[[int, int], None] | None = None
) -> dict[str, Array]:
    """Changes against the passive car (2, 3) of ours and of a constant duty in deflection, comfort and tyre load."""
    found = {}
    for name, case in CASES.items():
        found[name] = np.mean([_one(setup, case, k, constant) for k in range(seeds)], axis=0)
        if tick is not None:
            tick(len(found), len(CASES))
    return found


def _one(setup: Setup, case: Case, number: int, constant: float) -> Array:
    """One road."""
    car = _car(setup.model, case)
    road = contest.iso(setup.model, contest.SCORED + number, seconds=12.0).heights
    sensors = Sensors(latency=case.latency, lost=case.lost)
    nobody = Watch(lambda: None, lambda state, _: (state, None))
    laws = (
        (passive(0.0), nobody),
        (setup.built(replace(setup.parameters, u_max=1.0)), estimated(setup.model, car)),
        (passive(constant), nobody),
    )
    bare, ours, held = (
        _felt(drive(car, road, DT, law, watch, sensors, number), car) for law, watch in laws
    )
    return np.array([ours / bare - 1.0, held / bare - 1.0])


def _car(model: Model, case: Case) -> Model:
    """The true car: another load, and a leak that appears."""
    effects = {name: dict(values) for name, values in model.effects.items()}
    effects["quarter_car"]["m_s"] *= case.mass
    return replace(model, effects=effects).with_effect("oil_leakage", {"f": 0.6, "t_0": 1.0})


def _felt(record: Mapping[str, Array], car: Model) -> Array:
    """Deflection, comfort and tyre load, rms (3,)."""
    rows = record["t"] >= BEGIN
    felt = weighted(record["sprung_acceleration"], DT)
    values = (
        record["deflection"],
        felt,
        car.value("quarter_car", "k_t") * record["tyre_deflection"],
    )
    return np.array([float(np.sqrt(np.mean(v[rows] ** 2))) for v in values])


def markdown(found: Mapping[str, Array], constant: float) -> str:
    """The rows as a table, in per cent."""
    heads = "deflection, comfort, tyre load: ours | the same: constant duty"
    lines = [f"| case | {heads} {constant:g} |", "|---|---|---|"]
    for name, both in found.items():
        cells = (", ".join(f"{100.0 * v:+.1f}" for v in row) for row in both)
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines)
