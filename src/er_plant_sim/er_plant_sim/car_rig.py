"""The rig of a whole car without ROS: as `er_plant_sim.rig`, with four corners below one body.

measurements = sense(rig, state)               # at t_k, one a corner
state, applied = decide(rig, state)            # the duties of [t_k, t_{k+1})
state = advance(rig, state, forward, left)     # to t_{k+1}, under the car's acceleration [m/s2]
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from er_models.car.body import CORNERS, Car
from er_models.car.files import load_car
from er_models.car.simulation import CarOutput, CarPlant, car_at_rest, prepare_car, step_car
from er_models.car.surface import four_roads
from er_models.errors import InputError
from er_models.own import effects
from er_models.program import Program, load_program, within
from er_models.simulation import State, substeps
from numpy.typing import NDArray

from er_plant_sim import duty_gate
from er_plant_sim.build import sensor_errors
from er_plant_sim.car_settings import CarParameters
from er_plant_sim.duty_gate import Applied, Command, Gate, GateState
from er_plant_sim.noise import Noise
from er_plant_sim.rig_parameters import for_this_run, gate, of_a_wheel, scaled
from er_plant_sim.simulator import Measurement, sensed

Array = NDArray[np.float64]
BLOCK = 16
"""Ticks for which roads are computed at once."""
APART = 65537
"""Between the seeds of the corners' noise."""


@dataclass(frozen=True, eq=False)
class CarRig:
    """Car, limits of the duties and errors of the sensors (one a corner), and the program of road and duty."""

    plant: CarPlant
    gates: tuple[Gate, ...]
    noises: tuple[Noise, ...]
    program: Program
    programmed: bool
    speed: float
    coherence: float
    never: Array = field(default_factory=lambda: np.zeros(4))

    @property
    def car(self) -> Car:
        """Body and corners."""
        return self.plant.car

    @property
    def dt(self) -> float:
        """Sample time [s]."""
        return self.plant.dt


class CarState(NamedTuple):
    """Tick (from 1), states of the corners, what ideal sensors read there, and the duty gates."""

    tick: int
    corners: tuple[State, ...]
    output: CarOutput
    gates: tuple[GateState, ...]


def build(p: CarParameters) -> CarRig:
    """The rig of these parameters.

    Raises:
        InputError: A file cannot be used, or parameters contradict one another.
    """
    if p.mode == "realtime" and p.rate_factor != 1.0:
        raise InputError("parameters", "rate_factor", "1 in mode realtime", f"{p.rate_factor:g}")
    if not p.program_file:
        raise InputError("parameters", "program_file", "a program file", "nothing")
    car = load_car(p.car_file, effects(p.effects_from))
    program = for_this_run(p, of_a_wheel(p.program_file, load_program(p.program_file)))
    program, _ = scaled(program, car.corners[0], 1.0 / p.rate)
    one, constant = sensor_errors(p, "noise"), sensor_errors(p, "bias")
    noises = tuple(Noise(one, constant, program.seed + APART * i) for i in range(len(CORNERS)))
    gates = tuple(gate(p, model) for model in car.corners)
    plant = prepare_car(car, 1.0 / p.rate)
    return CarRig(plant, gates, noises, program, p.duty_source == "program", p.speed, p.coherence)


def start(rig: CarRig) -> CarState:
    """The first tick: the car stood at rest until one sample ago, with the safe or first duty."""
    wanted = [_programmed(rig, 0) if rig.programmed else g.safe_duty for g in rig.gates]
    duty = [min(max(u, g.duty_min), g.duty_max) for u, g in zip(wanted, rig.gates)]
    corners = car_at_rest(rig.plant, roads(rig, 0)[:, -1], np.array(duty))
    corners, output = step_car(rig.plant, corners, roads(rig, 1), np.array(duty))
    return CarState(1, corners, output, tuple(GateState(u, 0.0) for u in duty))


def sense(rig: CarRig, state: CarState) -> tuple[Measurement, ...]:
    """What the sensors of each corner read at this tick."""
    parts = zip(rig.noises, state.corners, state.output.corners)
    return tuple(sensed(noise, state.tick, corner.road, o) for noise, corner, o in parts)


def receive(
    rig: CarRig, state: CarState, corner: int, command: Command, *, valid: bool
) -> CarState:
    """Take a command of a corner's duty; not where the program says the duty."""
    if rig.programmed:
        return state
    if command.seq > state.tick:  # it was meant for a plant that was here before
        command = command._replace(seq=0)
    gates = list(state.gates)
    gates[corner] = duty_gate.receive(gates[corner], command, valid=valid, newest=state.tick)
    return state._replace(gates=tuple(gates))


def decide(
    rig: CarRig, state: CarState, conflicts: tuple[bool, ...] = (False,) * 4
) -> tuple[CarState, tuple[Applied, ...]]:
    """The duties from this tick until the next; conflicts: corners whose duty several publishers command."""
    t = state.tick * rig.dt
    made = [
        duty_gate.program(limits, held, t, _programmed(rig, state.tick))
        if rig.programmed
        else duty_gate.step(limits, held, t, conflict=conflict)
        for limits, held, conflict in zip(rig.gates, state.gates, conflicts)
    ]
    return state._replace(gates=tuple(g for g, _ in made)), tuple(a for _, a in made)


def advance(rig: CarRig, state: CarState, forward: float = 0.0, left: float = 0.0) -> CarState:
    """The state at the next tick, with the duties that were decided, while the car accelerates so [m/s2]."""
    push = rig.never
    if forward or left:
        push = rig.car.push(np.array([forward]), np.array([left]))[0]
    duty = np.array([g.duty for g in state.gates])
    corners, output = step_car(rig.plant, state.corners, roads(rig, state.tick + 1), duty, push)
    return CarState(state.tick + 1, corners, output, state.gates)


def finished(rig: CarRig, state: CarState) -> bool:
    """Whether the program is over."""
    return 0.0 < rig.program.duration < state.tick * rig.dt - 1e-9


def roads(rig: CarRig, tick: int) -> Array:
    """Heights below the corners at every step of the integrator after the tick before, (4, m) [m]; at tick 0 there."""
    if tick == 0:
        return _heights(rig, 0)[:, :1]
    lines = substeps(rig.dt)
    block, place = divmod(tick - 1, BLOCK)
    return _heights(rig, block)[:, place * lines + 1 : (place + 1) * lines + 1]


@lru_cache(maxsize=4)
def _heights(rig: CarRig, block: int) -> Array:
    """Roads from a block's first tick to the next one's, (4, m BLOCK + 1)."""
    t = within(BLOCK + 1, rig.dt, block * BLOCK)
    return four_roads(rig.program, rig.car, rig.speed, rig.coherence, t)


@lru_cache(maxsize=64)
def _programmed(rig: CarRig, tick: int) -> float:
    """Duty the program asks for from a tick on [1]."""
    return float(rig.program.duties(np.array([tick * rig.dt]))[0])
