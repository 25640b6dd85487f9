"""Simulation of the whole car on four roads: whole records, and one sample at a time for the plant node."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from er_models.car.body import CORNERS, MOTIONS, Car
from er_models.errors import InputError
from er_models.kernel.load import kernel, plain
from er_models.model import Array, Compiled, Model
from er_models.simulation import Output, Plant, State, initial_state, prepare


@dataclass(frozen=True)
class CarPlant:
    """A car prepared for stepping with a fixed sample time; corners: as `er_models.prepare` makes them."""

    car: Car
    dt: float
    corners: tuple[Plant, ...]

    @cached_property
    def compiled(self) -> tuple[Compiled, ...]:
        """The corners for the kernel: their sprung mass is what the body opposes there."""
        return tuple(
            _with_mass(p, m) for p, m in zip(self.corners, 1 / np.diag(self.car.compliance))
        )

    @cached_property
    def wheels(self) -> Array:
        """Unsprung masses, (4,) [kg]."""
        return np.array([p.model.value("quarter_car", "m_us") for p in self.corners])


class CarOutput(NamedTuple):
    """What the sensors of each corner would read without noise, and accelerations of heave, roll, pitch, (3,)."""

    corners: tuple[Output, ...]
    body: Array


def prepare_car(car: Car, dt: float) -> CarPlant:
    """A car ready for `step_car`; dt: time of a step [s].

    Raises `InputError` where the corners cannot be stepped together: effects of different catalogues.
    """
    corners = tuple(prepare(model, dt) for model in car.corners)
    if any(p.model.catalogue is not corners[0].model.catalogue for p in corners):
        raise InputError(car.name, "corners", "effects of one catalogue", "several")
    return CarPlant(car, dt, corners)


def _with_mass(plant: Plant, mass: float) -> Compiled:
    """A corner's vectors with another sprung mass [kg]."""
    p = plant.c.p.copy()
    p[plant.model.catalogue.column("quarter_car", "m_s")] = mass
    return replace(plant.c, p=p)


def car_at_rest(plant: CarPlant, road: Array, duty: Array) -> tuple[State, ...]:
    """The car standing on a level of its own under each wheel (4,) [m], dampers settled at duties (4,)."""
    states = zip(plant.corners, road.tolist(), duty.tolist())
    return tuple(initial_state(p, height, u) for p, height, u in states)


def step_car(
    plant: CarPlant, states: Sequence[State], road: Array, duty: Array, push: Array | None = None
) -> tuple[tuple[State, ...], CarOutput]:
    """The car one sample later, and what its sensors read then: a pure step.

    road (4, m): heights under each wheel at the ends of m equal parts of the sample [m], m a divisor of the
    substeps; duty (4,): held during it; push (4,): acceleration of the body by loads (`Car.push`) [m/s2].
    """
    lines = np.concatenate([np.array([[s.road] for s in states]), road], axis=1)
    rates = (lines[:, -1:] - lines[:, -2:-1]) * (road.shape[1] / plant.dt)
    loads = np.zeros((1, 4)) if push is None else push[None]
    ends, _, outputs, true = _run(plant, states, lines, duty[:, None], rates, loads)
    read = tuple(
        Output(a_s, a_us, x, v, f, f_m)
        for a_s, a_us, f, f_m, x, v in (one[0].tolist() for one in outputs)
    )
    return ends, CarOutput(read, plant.car.motions @ true[0])


def simulate_car(
    car: Car,
    dt: float,
    road: Array,
    duty: Array,
    forward: Array | None = None,
    left: Array | None = None,
) -> dict[str, Array]:
    """Record of the car without noise, from rest: channels by name [SI].

    dt: time between samples [s]; duty (4, n): held from each sample on; road (4, m (n - 1) + 1): heights [m] that
    part each sample into m lines, m a divisor of the substeps; forward, left: acceleration of the car [m/s2], (n,).
    Channels: t (n,), `CORNER/deflection` and so on as `er_models.simulate` names them, and `heave`, `roll`, `pitch`
    of the body with `heave_acceleration` and so on, `seat_acceleration`.

    Source: Milliken and Milliken, Race Car Vehicle Dynamics, ch. 16 to 18 (bars, load transfer); thesis, perspective.

    Raises:
        InputError: As `prepare_car`; arrays that do not fit one another.
    """
    plant = prepare_car(car, dt)
    n = duty.shape[-1]
    lines = (road.shape[-1] - 1) // max(n - 1, 1)
    if (
        duty.shape != (4, n)
        or road.shape != (4, lines * (n - 1) + 1)
        or plant.corners[0].n_sub % max(lines, 1)
    ):
        expected = f"(4, m (n - 1) + 1) heights beside (4, n) duties, m a divisor of {plant.corners[0].n_sub}"
        raise InputError("simulate_car", "road", expected, f"{road.shape} beside {duty.shape}")
    loads = car.push(
        *(np.zeros(n) if a is None else np.asarray(a, float) for a in (forward, left))
    )
    start = car_at_rest(plant, road[:, 0], duty[:, 0])
    rates = np.diff(road)[:, lines - 1 :: lines] * (lines / dt)
    _, states, outputs, true = _run(plant, start, road, duty[:, :-1], rates, loads[:-1])
    return _channels(
        car,
        dt,
        road[:, ::lines],
        duty,
        np.concatenate([[[s.q for s in start]], states]),
        outputs,
        true,
    )


def _channels(
    car: Car,
    dt: float,
    road: Array,
    duty: Array,
    states: Array,
    outputs: Sequence[Array],
    true: Array,
) -> dict[str, Array]:
    """A record's channels; at its first sample the car still stands."""
    record: dict[str, Array] = {"t": dt * np.arange(duty.shape[1], dtype=np.float64)}
    for i, name in enumerate(CORNERS):
        read = np.concatenate([np.zeros((1, 6)), outputs[i]])
        read[0, 2:4] = read[1, 2:4]
        record |= {
            f"{name}/{channel}": value
            for channel, value in (
                ("road", road[i]), ("duty", duty[i]), ("deflection", read[:, 4]), ("deflection_velocity", read[:, 5]),
                ("damper_force", read[:, 3]), ("sprung_acceleration", read[:, 0]),
                ("unsprung_acceleration", read[:, 1]), ("tyre_deflection", states[:, i, 2]),
            )
        }  # fmt: skip
    height = states[:, :, 0] + states[:, :, 2] + road.T
    accelerations = np.concatenate([np.zeros((1, 4)), true]) @ car.motions.T
    for k, name in enumerate(MOTIONS):
        record[name] = (height @ car.motions.T)[:, k]
        record[f"{name}_acceleration"] = accelerations[:, k]
    body = {name: accelerations[:, k] for k, name in enumerate(MOTIONS)}
    record["seat_acceleration"] = car.at(body, car.seat)
    return record


def _run(
    plant: CarPlant, states: Sequence[State], road: Array, duty: Array, rates: Array, push: Array
) -> tuple[tuple[State, ...], Array, tuple[Array, ...], Array]:
    """States after roads, mechanical states (n, 4, 4), outputs (n, 6) a corner, accelerations of the body (n, 4)."""
    n, corners, c = duty.shape[1], plant.corners, plant.compiled
    q = np.array([s.q for s in states])
    w, memory = tuple(s.w.copy() for s in states), tuple(s.memory.copy() for s in states)
    mechanical, true = np.empty((n, 4, 4)), np.empty((n, 4))
    outputs = tuple(np.empty((n, 6)) for _ in corners)
    catalogue = corners[0].model.catalogue
    kernel(catalogue).run_car(
        tuple(x.on for x in c), tuple(x.slots for x in c), tuple(x.links for x in c), tuple(x.p for x in c), q, w,
        tuple(s.duties for s in states), plain(duty), states[0].t, plant.dt, plain(road), plain(rates),
        corners[0].n_sub, min(p.tolerance for p in corners), tuple(p.reading for p in corners), memory,
        plain(plant.car.compliance), plant.car.bars, plant.wheels, plain(push), mechanical, outputs, true,
    )  # fmt: skip
    ends = tuple(
        State(
            s.t + n * plant.dt, float(road[i, -1]), q[i].copy(), w[i],
            np.concatenate([s.duties, duty[i]])[-p.depth :], memory[i],
        )
        for i, (p, s) in enumerate(zip(corners, states))
    )  # fmt: skip
    return ends, mechanical, outputs, true


def with_corner(car: Car, corner: str, model: Model) -> Car:
    """The car with another model at one corner: an effect or a fault that the others do not have."""
    if corner not in CORNERS:
        raise InputError(car.name, corner, f"one of {', '.join(CORNERS)}", "an unknown corner")
    place = CORNERS.index(corner)
    return replace(car, corners=(*car.corners[:place], model, *car.corners[place + 1 :]))
