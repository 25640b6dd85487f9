"""The whole rig without ROS: program, duty gate, plant and sensors, one tick after the other.

    measurement = sense(rig, state)            # at t_k, published at once
    state, applied = decide(rig, state, ...)   # the duty of [t_k, t_{k+1})
    state = advance(rig, state)                # to t_{k+1}

Time is the tick times the sample time; nothing here knows a clock.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from er_models.interlude import Drive, rules
from er_models.program import within
from er_models.simulation import substeps
from numpy.typing import NDArray

from er_plant_sim import duty_gate, simulator
from er_plant_sim.duty_gate import Applied, Command, Gate, GateState
from er_plant_sim.simulator import Measurement, SimState, Simulator

Array = NDArray[np.float64]

BLOCK = 16
"""Ticks for which road and duty are computed at once: a random road takes 50 us a tick, and the loop waits."""


@dataclass(frozen=True, eq=False)
class Rig:
    """Simulator, limits of the duty, and the drive: a program of road and duty (peak velocity resolved).

    programmed: the duty is that of the program; otherwise commands are waited for. known: road [m] of the first
    ticks, as `Program.ride` has it, where it was computed beforehand.
    """

    sim: Simulator
    gate: Gate
    program: Drive
    programmed: bool
    known: Array = field(default_factory=lambda: np.empty(0))

    @property
    def dt(self) -> float:
        """Sample time [s]."""
        return self.sim.dt


class RigState(NamedTuple):
    """State of the plant and of the duty gate."""

    sim: SimState
    gate: GateState


def start(rig: Rig) -> RigState:
    """The first tick: the car stood at rest until one sample ago, with the safe or first duty."""
    duty = wanted_duty(rig, 0) if rig.programmed else rig.gate.safe_duty
    gate = GateState(min(max(duty, rig.gate.duty_min), rig.gate.duty_max), 0.0)
    at_rest = simulator.at_rest(rig.sim, road(rig, 0), gate.duty)
    return RigState(simulator.advance(rig.sim, at_rest, way(rig, 1), gate.duty), gate)


def sense(rig: Rig, state: RigState) -> Measurement:
    """What the sensors read at this tick."""
    return simulator.measure(rig.sim, state.sim)


def receive(rig: Rig, state: RigState, command: Command, *, valid: bool) -> RigState:
    """Take a command of the duty; not where the program says the duty.

    One that answers a tick still to come is meant for a plant that was here before: its number means nothing.
    """
    if rig.programmed:
        return state
    newest = state.sim.tick
    if command.seq > newest:
        command = command._replace(seq=0)
    gate = duty_gate.receive(state.gate, command, valid=valid, newest=newest)
    return RigState(state.sim, gate)


def resumed(state: RigState) -> RigState:
    """The state after a pause: the last command answers a sample of before it."""
    return RigState(state.sim, state.gate._replace(command=None, answered=0, ahead=0))


def decide(rig: Rig, state: RigState, *, conflict: bool = False) -> tuple[RigState, Applied]:
    """The duty from this tick until the next; conflict: several publishers command it."""
    t = time(rig, state)
    if rig.programmed or rules(rig.program, t):
        wanted = wanted_duty(rig, state.sim.tick)
        gate, applied = duty_gate.program(rig.gate, state.gate, t, wanted)
    else:
        gate, applied = duty_gate.step(rig.gate, state.gate, t, conflict=conflict)
    return RigState(state.sim, gate), applied


def advance(rig: Rig, state: RigState) -> RigState:
    """The state at the next tick, with the duty that was decided."""
    ahead = way(rig, state.sim.tick + 1)
    return RigState(simulator.advance(rig.sim, state.sim, ahead, state.gate.duty), state.gate)


def time(rig: Rig, state: RigState) -> float:
    """Time of the tick since the start [s]."""
    return state.sim.tick * rig.dt


def finished(rig: Rig, state: RigState) -> bool:
    """Whether the program is over."""
    return 0.0 < rig.program.duration < time(rig, state) - 1e-9


def road(rig: Rig, tick: int) -> float:
    """Height of the road at a tick [m]."""
    return float(way(rig, tick)[-1])


def way(rig: Rig, tick: int) -> Array:
    """Heights of the road [m] at every step of the integrator after the tick before, (m,); at tick 0 only there."""
    lines = substeps(rig.dt)
    if tick == 0:
        return rig.known[:1] if rig.known.size else _heights(rig, 0)[:1]
    first = (tick - 1) * lines + 1
    if first + lines <= rig.known.size:
        return rig.known[first : first + lines]
    first -= (tick - 1) // BLOCK * BLOCK * lines
    return _heights(rig, (tick - 1) // BLOCK)[first : first + lines]


def wanted_duty(rig: Rig, tick: int) -> float:
    """Duty the program asks for from a tick on [1]."""
    return float(_duties(rig, tick // BLOCK)[tick % BLOCK])


@lru_cache(maxsize=4)
def _heights(rig: Rig, block: int) -> Array:
    """Road from a block's first tick to the next one's, (m BLOCK + 1,)."""
    return rig.program.heights(within(BLOCK + 1, rig.dt, block * BLOCK))


@lru_cache(maxsize=4)
def _duties(rig: Rig, block: int) -> Array:
    """Duty of one block of ticks (BLOCK,)."""
    return rig.program.duties(_times(rig, block))


def _times(rig: Rig, block: int) -> Array:
    """Times of one block of ticks (BLOCK,) [s]."""
    ticks = np.arange(block * BLOCK, (block + 1) * BLOCK, dtype=np.float64)
    return np.asarray(rig.dt * ticks, np.float64)
