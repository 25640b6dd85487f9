"""The simulated rig, one tick at a time: what the sensors read, then what the duty does.

At tick k (from 1) the state is that at t_k: `measure` gives the sensors, the duty gate decides the
duty of [t_k, t_{k+1}), `advance` integrates over it. So a duty published with the stamp t_k acted
from t_k on.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from er_models.model import Array, Model
from er_models.simulation import Output, Plant, State, initial_state, prepare
from er_models.simulation import step as step_plant

from er_plant_sim.noise import Noise, errors


@dataclass(frozen=True)
class Simulator:
    """A vehicle model prepared for stepping, and the errors of its sensors."""

    plant: Plant
    noise: Noise

    @property
    def dt(self) -> float:
        """Sample time [s]."""
        return self.plant.dt


class SimState(NamedTuple):
    """Tick (0 before the first), state of the quarter car, what ideal sensors would read."""

    tick: int
    plant: State
    output: Output | None = None


class Measurement(NamedTuple):
    """What the sensors read at a tick [SI]; contract's names and signs."""

    tick: int
    road: float
    sprung_acceleration: float
    unsprung_acceleration: float
    deflection: float
    deflection_velocity: float
    force: float


def simulator(model: Model, dt: float, noise: Noise) -> Simulator:
    """Prepare a vehicle model for stepping with sample time dt [s].

    Raises:
        InputError: The model has no quarter car.
    """
    return Simulator(prepare(model, dt), noise)


def at_rest(p: Simulator, road: float, duty: float) -> SimState:
    """The car standing on the road at height road [m], the damper settled at this duty."""
    return SimState(0, initial_state(p.plant, road, duty))


def advance(p: Simulator, state: SimState, way: float | Array, duty: float) -> SimState:
    """The state one sample later: way is the road on it (m,) [m], see `step`, duty what was held until then."""
    plant, output = step_plant(p.plant, state.plant, (way, duty))
    return SimState(state.tick + 1, plant, output)


def measure(p: Simulator, state: SimState) -> Measurement:
    """What the sensors read; the road is reported as it is. Needs an `advance` before."""
    if state.output is None:
        raise ValueError("the first tick is 1: advance once before measuring")
    return sensed(p.noise, state.tick, state.plant.road, state.output)


def sensed(noise: Noise, tick: int, road: float, o: Output) -> Measurement:
    """What the sensors make at a tick of what ideal ones would read."""
    e = errors(noise, tick)
    return Measurement(
        tick,
        road,
        o.sprung_acceleration + e.sprung_acceleration,
        o.unsprung_acceleration + e.unsprung_acceleration,
        o.deflection + e.deflection,
        o.deflection_velocity + e.deflection_velocity,
        o.measured_force + e.force,
    )


def damper_replaced(vehicle: Model, damper: Model) -> Model:
    """The vehicle with all effects of its damper replaced by those of another damper model.

    This is how an effect is hidden in the plant while the model of the vehicle stays what it was.
    What the damper file says of itself (envelope, rig) counts as well.
    """
    from dataclasses import replace

    own = {name: values for name, values in vehicle.effects.items() if _of_vehicle(vehicle, name)}
    foreign = {
        name: values for name, values in damper.effects.items() if not _of_vehicle(damper, name)
    }
    return replace(
        vehicle, effects={**foreign, **own}, scales=damper.scales, rig=damper.rig or vehicle.rig
    )


def _of_vehicle(model: Model, name: str) -> bool:
    """Whether an effect belongs to the vehicle rather than to its damper."""
    return model.catalogue[name].stage == "vehicle"
