"""Drives a scenario: the true force of the plant, and what an observer is told of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from er_models.constants import SAMPLE_TIME as DT
from er_models.files import load_model
from er_models.model import Array, Model
from er_models.program import resolve
from er_models.simulation import Plant as Prepared
from er_models.simulation import initial_state, prepare, simulate, step

from er_studies.observers.scenarios.scenario import Plant, Scenario, Sensors, Skyhook

COLUMNS = (
    "t", "road", "deflection", "deflection_velocity", "duty", "damper_force",
    "sprung_acceleration", "unsprung_acceleration", "tyre_deflection",
)  # fmt: skip
_NOISE, _PLANT, _DEFLECTION = 1, 2, 3  # streams of random numbers beside the road's own


def drive(scenario: Scenario, believed: Model, number: int = 0) -> dict[str, Array]:
    """Record of road `number` of a scenario, each (n,): the truth under the contract's names.

    `told_*` are the two accelerations, the duty and the deflection as an observer gets them. The road is scaled by
    the believed model, so that every plant of a scenario meets the same one.
    """
    seed = scenario.program.seed + number
    program = resolve(replace(scenario.program, seed=seed), believed, DT)
    road, duty = program.ride(DT)
    plant = plant_of(scenario.plant, believed, seed)
    duty_step = scenario.sensors.duty_step
    if scenario.skyhook is not None:
        record = _closed_loop(plant, road, scenario.skyhook)
    else:
        record = simulate(plant, DT, road, quantised(duty, duty_step))
    told = record["duty"] if scenario.skyhook is not None else duty
    return {**record, **_told(record, told, scenario.sensors, seed)}


def plant_of(plant: Plant, believed: Model, seed: int) -> Model:
    """The car of a scenario for one seed: another file, other parameters, more effects."""
    model = load_model(plant.model) if plant.model else believed
    if plant.spread > 0.0:
        random = np.random.default_rng([seed, _PLANT])
        effects = {
            name: {q: v * random.uniform(1.0 - plant.spread, 1.0 + plant.spread) for q, v in values.items()}
            for name, values in model.effects.items()
        }  # fmt: skip
        model = replace(model, effects=effects)
    for name, values in plant.effects.items():
        model = model.with_effect(name, values)
    return model


def quantised(duty: Array, step_of_duty: float) -> Array:
    """The duty rounded to a step; a step of zero changes nothing."""
    return np.round(duty / step_of_duty) * step_of_duty if step_of_duty > 0.0 else duty


def _closed_loop(plant: Model, road: Array, limits: Skyhook) -> dict[str, Array]:
    """The plant on a road (m (n - 1) + 1,), the duty from (3.81) on the true velocities, sample by sample."""
    prepared = prepare(plant, DT)
    state = initial_state(prepared, float(road[0]), limits.low)
    rows = [_first(prepared, plant, road)]
    for way in road[1:].reshape(-1, prepared.n_sub):
        duty = _skyhook(limits, state.q)
        rows[-1][4] = duty
        state, out = step(prepared, state, (way, duty))
        rows.append([
            state.t, state.road, out.deflection, out.deflection_velocity, duty, out.measured_force,
            out.sprung_acceleration, out.unsprung_acceleration, float(state.q[2]),
        ])  # fmt: skip
    rows[-1][4] = _skyhook(limits, state.q)
    return dict(zip(COLUMNS, np.array(rows).T, strict=True))


def _first(prepared: Prepared, plant: Model, road: Array) -> list[float]:
    """The first row, at rest: what an open loop of two samples begins with."""
    record = simulate(plant, prepared.dt, road[: prepared.n_sub + 1], np.zeros(2))
    return [float(record[name][0]) for name in COLUMNS]


def _skyhook(limits: Skyhook, q: Array) -> float:
    """Duty of (3.81) for the mechanical state q = [z_def, v_s, z_us - z_r, v_us]."""
    return limits.high if q[1] * (q[1] - q[3]) >= 0.0 else limits.low


def _told(
    record: Mapping[str, Array], duty: Array, sensors: Sensors, seed: int
) -> dict[str, Array]:
    """What an observer gets: accelerations late, biased and noisy, and the duty that was asked for."""
    random = np.random.default_rng([seed, _NOISE])
    late = round(sensors.delay / DT)
    told = {"told_duty": duty}
    for name, sign in (("sprung_acceleration", 1.0), ("unsprung_acceleration", -1.0)):
        true = record[name]
        seen = np.concatenate([np.full(late, true[0]), true[: true.size - late]])
        noise = sensors.noise * random.standard_normal(true.size)
        told[f"told_{name}"] = seen + sign * sensors.bias + noise
    drawn = np.random.default_rng([seed, _DEFLECTION]).standard_normal(record["t"].size)
    told["told_deflection"] = record["deflection"] + sensors.deflection * drawn
    return told
