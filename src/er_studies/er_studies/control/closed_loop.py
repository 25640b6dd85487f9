"""The closed loop without ROS: car, sensors, fault estimate and controller, sample by sample, from seeds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from er_ftc_controller.control import Faults, Mode, Sample
from er_models.fault_profile import left as what_is_left
from er_models.model import Array, Model
from er_models.simulation import Output, initial_state, prepare
from er_models.simulation import step as step_plant

from er_studies.control.rivals import Law

FAULTS = ("electrical_fault", "oil_leakage", "duct_deformation")
"""Effects of f1, f2, f3."""
_NOISE = 7  # stream of random numbers beside the road's own
_LOST = 8
_TICK = 200  # samples from one word of how far a drive is to the next


@dataclass(frozen=True)
class Sensors:
    """Standard deviations: accelerometers [m/s2], deflection [m], its velocity [m/s], force [N]; latency in samples.

    lost: share of the samples that reach neither controller nor estimator.
    """

    acceleration: float = 0.025
    deflection: float = 2.0e-5
    velocity: float = 1.0e-3
    force: float = 0.15
    latency: int = 0
    lost: float = 0.0


class Told(NamedTuple):
    """What an estimator sees at a sample: the sensors and the duty that is in force from then on."""

    t: float
    sprung_acceleration: float
    unsprung_acceleration: float
    deflection: float
    velocity: float
    duty: float
    force: float


class Watch(NamedTuple):
    """A source of fault estimates: its first state, and its step to an estimate or None."""

    start: Callable[[], Any]
    step: Callable[[Any, Told], tuple[Any, Faults | None]]


COLUMNS = (
    "t", "road", "deflection", "deflection_velocity", "sprung_acceleration", "tyre_deflection",
    "damper_force", "duty", "wanted", "given", "rho", "safe", "adapted", "meant_deflection", "meant_velocity",
)  # fmt: skip


def true_factors(car: Model, t: float) -> tuple[float, float, float]:
    """Factors f1, f2, f3 that the faults of a car leave at time t [s]."""

    def one(name: str) -> float:
        return what_is_left(**car.effects[name], t=t) if name in car.effects else 1.0

    f1, f2, f3 = (one(name) for name in FAULTS)
    return f1, f2, f3


def known(_believed: Model, car: Model) -> Watch:
    """The true faults, as if somebody told them."""

    def step(state: None, told: Told) -> tuple[None, Faults]:
        left = true_factors(car, told.t)
        return state, Faults(told.t, *left, certain=min(left) < 1.0, usable=True)

    return Watch(lambda: None, step)


def drive(
    car: Model, road: Array, dt: float, law: Law, watch: Watch, sensors: Sensors, seed: int,
    tick: Callable[[float], None] | None = None,
) -> dict[str, Array]:  # fmt: skip
    """The car on a road as of `Program.ride`, n samples dt [s] apart: `COLUMNS`, each (n,), left, believed (n, 3).

    The duty of a sample acts until the next one, or `latency` samples later. No controller sees the road.
    tick: told the time [s] every `_TICK` samples.
    """
    plant = prepare(car, dt)
    state, out = initial_state(plant, float(road[0])), Output(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    ways = road[1:].reshape(-1, plant.n_sub)
    noise = _noise(sensors, len(ways) + 1, seed)
    lost = np.random.default_rng([seed, _LOST]).random(len(ways) + 1) < sensors.lost
    mind, opinion = law.start(), watch.start()
    pending, told_duty = [0.0] * (sensors.latency + 1), 0.0
    rows, left, believed = [], [], []
    for k in range(len(ways) + 1):
        t = k * dt
        if tick is not None and k % _TICK == 0:
            tick(t)
        if k > 0:
            state, out = step_plant(plant, state, (ways[k - 1], told_duty))
        seen = _seen(out, noise[k])
        sample = Sample(seen[2], seen[3], seen[0], seen[1], duty=told_duty)
        mind, command = law.step(mind, t, None if lost[k] else sample)
        pending = [*pending[1:], command.duty]
        told_duty = pending[0] if sensors.latency else command.duty
        if not lost[k]:
            opinion, faults = watch.step(opinion, Told(t, *seen[:4], told_duty, seen[4]))
            if faults is not None:
                mind = law.hear(mind, faults)
        rows.append((
            t, state.road, out.deflection, out.deflection_velocity, out.sprung_acceleration, float(state.q[2]),
            out.damper_force, told_duty, command.wanted, command.given, command.rho,
            command.mode is Mode.SAFE, command.mode is Mode.FAULT_TOLERANT, command.x, command.v,
        ))  # fmt: skip
        left.append(true_factors(car, t))
        believed.append(command.left)
    record = dict(zip(COLUMNS, np.array(rows, float).T, strict=True))
    return record | {"left": np.array(left), "believed": np.array(believed)}


def _noise(sensors: Sensors, n: int, seed: int) -> Array:
    """Errors of both accelerations, deflection, velocity and force (n, 5)."""
    sizes = (sensors.acceleration,) * 2 + (sensors.deflection, sensors.velocity, sensors.force)
    return np.asarray(np.random.default_rng([seed, _NOISE]).standard_normal((n, 5)) * sizes)


def _seen(out: Output, error: Array) -> tuple[float, float, float, float, float]:
    """What the sensors read: both accelerations, deflection, velocity, force."""
    return (
        out.sprung_acceleration + float(error[0]),
        out.unsprung_acceleration + float(error[1]),
        out.deflection + float(error[2]),
        out.deflection_velocity + float(error[3]),
        out.measured_force + float(error[4]),
    )
