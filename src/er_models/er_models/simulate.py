"""Simulation of the quarter car on a road: whole records, and one sample at a time for the plant node."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from er_models import sensors
from er_models.errors import InputError
from er_models.kernel.load import kernel
from er_models.model import Array, Compiled, Model

SUBSTEP = 0.625e-3
"""Longest step of the integrator in the quarter car [s]."""
DEPTH = 16
"""Duties remembered for the dead time, in samples."""


class State(NamedTuple):
    """State of the quarter car: q = [z_def, v_s, z_us - z_r, v_us], w: damper states, duties: newest last.

    sensors: what the channels remember where the model holds sensing effects.
    """

    t: float
    road: float
    q: Array
    w: Array
    duties: Array
    sensors: sensors.Memory


class Output(NamedTuple):
    """What the sensors would read without noise, at the end of a step; damper_force is the true one [SI]."""

    sprung_acceleration: float
    unsprung_acceleration: float
    deflection: float
    deflection_velocity: float
    damper_force: float
    measured_force: float


@dataclass(frozen=True)
class Plant:
    """A vehicle model prepared for stepping with a fixed sample time."""

    model: Model
    dt: float
    c: Compiled
    n_sub: int
    tolerance: float
    channels: sensors.Channels


def prepare(model: Model, dt: float) -> Plant:
    """Prepare a vehicle model; `InputError` when the quarter car is missing."""
    if not model.is_vehicle:
        raise InputError(model.name, "quarter_car", "a vehicle model with quarter_car", "a damper only")
    n_sub = max(1, int(np.ceil(dt / SUBSTEP - 1e-9)))
    physical, channels = sensors.split(model, dt)
    return Plant(physical, dt, physical.compiled(), n_sub, 1e-9 * model.scales.velocity, channels)


def initial_state(plant: Plant, road: float = 0.0, duty: float = 0.0, q: Array | None = None) -> State:
    """At rest on the road, or at the mechanical state q (4,), with the damper settled."""
    c = plant.c
    state = np.zeros(4) if q is None else np.array(q, float)
    w = np.zeros(c.at_rest.shape[0])
    kernel(plant.model.catalogue).start_vehicle(c.on, c.slots, c.at_rest, c.p, state, w, duty, 0.0)
    out = np.empty(4)
    k = kernel(plant.model.catalogue)
    k.observe_vehicle(c.on, c.p, state, w, np.full(DEPTH, duty), plant.dt, out)
    memory = sensors.start(state[1] - state[3], float(out[3]))
    return State(0.0, road, state, w, np.full(DEPTH, duty), memory)


def step(plant: Plant, state: State, inputs: tuple[float, float]) -> tuple[State, Output]:
    """Advance by one sample: inputs are the road height at its end [m] and the duty held during it."""
    road, duty = inputs
    q, w, out = state.q.copy(), state.w.copy(), np.empty(4)
    duties = np.append(state.duties[1:], duty)
    c = plant.c
    kernel(plant.model.catalogue).step_vehicle(
        c.on, c.slots, c.passes, c.p, q, w, duties, state.t, plant.dt, state.road, road, plant.n_sub,
        plant.tolerance, out,
    )  # fmt: skip
    true = (float(q[0]), float(q[1] - q[3]), float(out[3]))
    memory, (x, v, force) = sensors.read(plant.channels, state.sensors, true)
    after = State(state.t + plant.dt, road, q, w, duties, memory)
    return after, Output(float(out[0]), float(out[1]), x, v, float(out[2]), force)


def simulate(model: Model, dt: float, road: Array, duty: Array, q: Array | None = None) -> dict[str, Array]:
    """Noise-free record of the quarter car: the contract's channels, each (n,).

    road (n,): height at each sample; duty (n,): held from each sample on.
    """
    plant = prepare(model, dt)
    start = initial_state(plant, float(road[0]), float(duty[0]), q)
    n, c = road.shape[0], plant.c
    states, outputs = np.empty((n, 4)), np.empty((n, 4))
    kernel(plant.model.catalogue).simulate_vehicle(
        c.on, c.slots, c.passes, c.p, start.q, start.w, np.ascontiguousarray(duty, float), dt,
        np.ascontiguousarray(road, float), plant.n_sub, plant.tolerance, states, outputs,
    )  # fmt: skip
    x, v, force = sensors.read_all(plant.channels, states[:, 0], states[:, 1] - states[:, 3], outputs[:, 3])
    return {
        "t": np.arange(n) * dt,
        "road": np.asarray(road, float),
        "deflection": x,
        "deflection_velocity": v,
        "duty": np.asarray(duty, float),
        "damper_force": force,
        "sprung_acceleration": outputs[:, 0],
        "unsprung_acceleration": outputs[:, 1],
        "tyre_deflection": states[:, 2],
    }
