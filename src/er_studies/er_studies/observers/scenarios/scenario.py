"""What a scenario is: drive, plant, sensors, how wrong an observer starts, and when errors count."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from er_models.model import Values
from er_models.program import Program


@dataclass(frozen=True)
class Window:
    """A stretch of time in which errors count, begin to end [s].

    table: the thesis's name of it. published: its NRMSE by observer; empty where it has none.
    """

    begin: float
    end: float
    table: str = ""
    published: Mapping[str, float] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The stretch in words."""
        return f"{self.begin:g}-{self.end:g} s"


@dataclass(frozen=True)
class Skyhook:
    """The duties that (3.81) switches between, on the true velocities."""

    low: float
    high: float


@dataclass(frozen=True)
class Plant:
    """The car that is simulated, where it is not the one the observers believe in.

    model: a vehicle model file, empty for the believed one. spread: every parameter is multiplied
    by a random number within 1 +- spread, another one for every seed. effects: added, with
    values; none given for its start.
    """

    model: str = ""
    spread: float = 0.0
    effects: Values = field(default_factory=dict)


@dataclass(frozen=True)
class Sensors:
    """What the accelerometers and the duty's report add.

    noise: standard deviation of both accelerometers [m/s2]. bias: of the sprung and, with the
    opposite sign, of the unsprung one [m/s2]. delay: of both [s], whole samples. duty_step: the
    rig applies the duty rounded to this step, observers are told the one asked for. deflection: noise
    of the deflection sensor [m], NaN where there is none.
    """

    noise: float = 0.025
    bias: float = 0.0
    delay: float = 0.0
    duty_step: float = 0.0
    deflection: float = math.nan


@dataclass(frozen=True)
class Scenario:
    """One drive, over `seeds` roads where the road is random.

    start: `thesis`, its own initial error for each observer; `equal`, the same for all; `drawn`,
    the same for all from the covariance that the Kalman filters are told, another one for every
    seed; `own`, what an observer makes of the first sample.
    """

    name: str
    title: str
    program: Program
    windows: tuple[Window, ...]
    seeds: int = 1
    start: str = "equal"
    skyhook: Skyhook | None = None
    plant: Plant = field(default_factory=Plant)
    sensors: Sensors = field(default_factory=Sensors)
