"""Simulation of the quarter car on a road: whole records, and one sample at a time for the plant node."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from er_models.errors import InputError
from er_models.kernel.load import kernel, plain
from er_models.model import Array, Compiled, Model
from er_models.reading import delay, reading

SUBSTEP = 0.3125e-3
"""Longest step of the integrator in the quarter car [s]."""
LONGEST_DELAY = 0.08
"""Duties are remembered this long for the dead time [s]."""
NOTHING = np.zeros(2)
"""Force beside the damper where there is none [N]."""


class State(NamedTuple):
    """State of the quarter car: q = [z_def, v_s, z_us - z_r, v_us], w: damper states, duties: newest last.

    memory: reported velocity, then the measured forces of the last steps, newest last.
    """

    t: float
    road: float
    q: Array
    w: Array
    duties: Array
    memory: Array


class Output(NamedTuple):
    """What the sensors would read without noise, at the end of a step [SI]."""

    sprung_acceleration: float
    unsprung_acceleration: float
    deflection: float
    deflection_velocity: float
    damper_force: float
    measured_force: float


@dataclass(frozen=True)
class Plant:
    """A vehicle model prepared for stepping with a fixed sample time.

    reading (5,): as `er_models.reading.reading`; depth: duties remembered; kept: forces
    remembered.
    """

    model: Model
    dt: float
    c: Compiled
    n_sub: int
    tolerance: float
    reading: Array
    depth: int
    kept: int


def substeps(dt: float) -> int:
    """Steps of the integrator within a sample of dt [s]: the road is known at the end of each."""
    return max(1, int(np.ceil(dt / SUBSTEP - 1e-9)))


def straight(road: Array, dt: float) -> Array:
    """The special case of a road that is straight between samples (n,) dt [s] apart: its heights at every step."""
    lines = substeps(dt)
    return np.interp(np.arange(lines * (len(road) - 1) + 1), lines * np.arange(len(road)), road)


def prepare(model: Model, dt: float) -> Plant:
    """A vehicle model ready for `step`; dt: time of a step [s].

    Raises `InputError` when the quarter car is missing or a sensor cannot be simulated.
    """
    if not model.is_vehicle:
        raise InputError(
            model.name, "quarter_car", "a vehicle model with quarter_car", "a damper only"
        )
    n_sub = substeps(dt)
    return Plant(
        model, dt, model.compiled(plant=True), n_sub, 1e-9 * model.scales.velocity, reading(model),
        depth=int(np.ceil(LONGEST_DELAY / dt)) + 1, kept=int(np.ceil(delay(model) * n_sub / dt)) + 3,
    )  # fmt: skip


def initial_state(
    plant: Plant, road: float = 0.0, duty: float = 0.0, q: Array | None = None
) -> State:
    """At rest on the road [m], or at the mechanical state q (4,) [m, m/s], with the damper settled at a duty [1]."""
    c = plant.c
    state = np.zeros(4) if q is None else np.array(q, float)
    w = np.zeros(c.at_rest.shape[0])
    memory = np.empty(1 + plant.kept)
    force = kernel(plant.model.catalogue).start_vehicle(
        c.on, c.slots, c.links, c.at_rest, c.p, state, w, float(duty)
    )
    memory[0] = (state[1] - state[3] - plant.reading[4]) / plant.reading[2]
    memory[1:] = force
    return State(0.0, float(road), state, w, np.full(plant.depth, float(duty)), memory)


def gone_over(plant: Plant, state: State) -> State:
    """The same car at the same instant with another damper, which begins settled in the motion that there is."""
    begun = initial_state(plant, state.road, float(state.duties[-1]), state.q)
    return begun._replace(t=state.t, duties=state.duties)


def step(plant: Plant, state: State, inputs: tuple[float | Array, float]) -> tuple[State, Output]:
    """The car one sample later, and what its sensors read then: a pure step, as `simulate` makes them.

    inputs: heights of the road [m] at the ends of m equal parts of the sample, (m,), m a divisor of `substeps`, or
    at its end alone, and the duty that is held during it [1].
    """
    way, duty = inputs
    heights = np.append(state.road, way)
    rates = (heights[-1:] - heights[-2:-1]) * ((heights.size - 1) / plant.dt)
    end, _, outputs = _run(
        plant, state, heights, np.array([duty], float), rates, False, np.zeros(2)
    )
    sprung, unsprung, true, measured, deflection, velocity = outputs[0].tolist()
    return end, Output(sprung, unsprung, deflection, velocity, true, measured)


def simulate(
    model: Model,
    dt: float,
    road: Array,
    duty: Array,
    q: Array | None = None,
    actuator_force: Array | None = None,
) -> dict[str, Array]:
    """Record of the quarter car without noise: channels by name, (n,) each [SI].

    dt: time between samples [s]; duty (n,): held from each sample on; road (m (n - 1) + 1,): heights [m] that part
    each sample into m lines, m a divisor of `substeps`; with m = 1 it is straight between samples; q (4,): mechanical
    state to begin with, at rest on the road where absent. actuator_force (n,): acts between the masses beside the
    damper, positive where it resists extension as a damper force does, straight between two samples [N].

    Channels: t, road, deflection, deflection_velocity, duty, damper_force, sprung_acceleration, unsprung_acceleration,
    tyre_deflection, sprung_displacement, unsprung_displacement, and the actuator's force where it is given.
    Displacements are 0 where the car stands on a road of height 0. Where the damper force jumps with the duty (no
    response time) a row holds the force under its own duty, while `step` cannot know the next one yet.

    Source: thesis (2.5).

    Raises:
        InputError: No quarter car in the model, a sensor that cannot be simulated, or an input that does not fit the
            road.
    """
    plant = prepare(model, dt)
    road, duty = np.asarray(road, np.float64), np.asarray(duty, np.float64)
    lines = _lines(plant, road, duty)
    given = {} if actuator_force is None else {"actuator_force": np.asarray(actuator_force, float)}
    for name, y in given.items():
        if y.shape != duty.shape:
            raise InputError("simulate", name, f"samples as the duty, {duty.shape}", f"{y.shape}")
    start = initial_state(plant, float(road[0]), float(duty[0]), q)
    _, states, outputs = history(plant, start, road, duty, beside=given.get("actuator_force"))
    wheel = states[:, 2] + road[::lines]
    return {
        "t": dt * np.arange(duty.size, dtype=np.float64),
        "road": road[::lines],
        "deflection": outputs[:, 4],
        "deflection_velocity": outputs[:, 5],
        "duty": duty,
        "damper_force": outputs[:, 3],
        "sprung_acceleration": outputs[:, 0],
        "unsprung_acceleration": outputs[:, 1],
        "tyre_deflection": states[:, 2],
        "sprung_displacement": states[:, 0] + wheel,
        "unsprung_displacement": wheel,
    } | given


def _lines(plant: Plant, road: Array, duty: Array) -> int:
    """Into how many lines a road parts each sample; `InputError` where it does not fit the duty."""
    if road.ndim == duty.ndim == 1 and road.size and duty.size:
        lines, rest = divmod(road.size - 1, duty.size - 1) if duty.size > 1 else (1, road.size - 1)
        if not rest and lines and not plant.n_sub % lines:
            return lines
    expected = (
        f"samples as the road, {road.shape}, or one in a divisor of {plant.n_sub} of its heights"
    )
    raise InputError("simulate", "duty", expected, f"{duty.shape}")


def history(
    plant: Plant,
    start: State,
    road: Array,
    duty: Array,
    rates: Array | None = None,
    beside: Array | None = None,
) -> tuple[State, Array, Array]:
    """A record (n,) from a state on: the state at its last sample, mechanical states (n, 4) and outputs (n, 6).

    outputs: both reported accelerations, true and measured force, reported deflection and velocity. road
    (m (n - 1) + 1,): m straight lines a sample, of which the plant's steps are a multiple. rates (n,): of the road
    at each sample [m/s]; else those of the lines that follow. beside (n,): force beside the damper at each sample [N];
    none where absent.
    """
    if rates is None:
        lines = max((road.size - 1) // max(duty.size - 1, 1), 1)
        rates = np.append(np.diff(road)[::lines] * (lines / plant.dt), 0.0)
    beside = np.zeros(rates.size) if beside is None else beside
    end, states, outputs = _run(plant, start, road, duty, rates[1:], True, beside)
    states = np.concatenate([start.q[None], states])
    first = _first(plant, start, float(rates[0]), float(beside[0]))
    return end, states, np.concatenate([first, outputs])


def _run(
    plant: Plant, state: State, road: Array, duty: Array, rates: Array, ahead: bool, beside: Array
) -> tuple[State, Array, Array]:
    """State after a road, mechanical states (n, 4) and outputs (n, 6) at the end of each sample."""
    c, n = plant.c, rates.shape[0]
    q, w, memory = state.q.copy(), state.w.copy(), state.memory.copy()
    states, outputs = np.empty((n, 4)), np.empty((n, 6))
    kernel(plant.model.catalogue).run_vehicle(
        c.on, c.slots, c.links, c.p, q, w, state.duties, plain(duty), state.t, plant.dt, plain(road), plain(rates),
        plain(beside), plant.n_sub, plant.tolerance, ahead, plant.reading, memory, states, outputs,
    )  # fmt: skip
    duties = np.concatenate([state.duties, duty[:n]])[-plant.depth :]
    end = State(state.t + n * plant.dt, float(road[-1]), q, w, duties, memory)
    return end, states, outputs


def _first(plant: Plant, start: State, slope: float, beside: float) -> Array:
    """Outputs (1, 6) at the start of a record."""
    c, out, rate = plant.c, np.zeros((1, 6)), np.zeros(start.w.shape[0])
    kernel(plant.model.catalogue).vehicle_point(
        c.on,
        c.slots,
        c.links,
        c.p,
        start.q,
        start.w,
        start.duties[-1],
        start.t,
        beside,
        slope,
        rate,
        rate.copy(),
        out,
    )
    out[0, :2] = out[0, 4:]
    out[0, 4] = (start.q[0] - plant.reading[1]) / plant.reading[0]
    out[0, 5] = start.memory[0]
    return out
