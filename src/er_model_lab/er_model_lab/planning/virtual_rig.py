"""A program run on the rig without noise: the quarter car on its road, or a damper in a test machine.

A vehicle model drives over the road. A damper alone is held at its upper end while the lower one
follows the road: the deflection is imposed, x = -road.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from er_models.model import Array, Model
from er_models.prediction import Motion, motion, predict
from er_models.program import Program, times
from er_models.reading import reading
from er_models.simulation import simulate

from er_model_lab.planning.limits import Limits

FINER = 4
"""The force of an imposed motion is computed on a grid so many times finer than the samples."""
EPSILON = 2e-4
"""Step [s] with which an imposed motion is differentiated."""


@dataclass(frozen=True)
class Run:
    """The contract's channels of one run, each (n,), and the sample time [s].

    travel: gain and offset [m] by which the deflection read is that of the damper; speed: those of its velocity [m/s].
    """

    dt: float
    channels: dict[str, Array]
    travel: tuple[float, float] = (1.0, 0.0)
    speed: tuple[float, float] = (1.0, 0.0)

    @property
    def motion(self) -> Motion:
        """What a lab with perfect sensors would take for the motion."""
        c = self.channels
        a = c["sprung_acceleration"] - c["unsprung_acceleration"]
        return motion(self.dt, c["deflection"], c["deflection_velocity"], c["duty"], a)

    @property
    def finite(self) -> bool:
        """Whether the simulation stayed finite."""
        return bool(np.isfinite(self.channels["damper_force"]).all())

    def used(self) -> dict[str, float]:
        """Peaks of the damper's deflection [m] and velocity [m/s], whatever its sensors read, of duty and road [m]."""
        c = self.channels
        moved = {
            "stroke": self.travel[0] * c["deflection"] + self.travel[1],
            "velocity": self.speed[0] * c["deflection_velocity"] + self.speed[1],
            "duty": c["duty"],
            "road": c["road"],
        }
        return {k: float(np.max(np.abs(y))) for k, y in moved.items()}

    def share(self, limits: Limits) -> float:
        """How much of the tightest limit of the motion is used; 1 is all of it."""
        if not self.finite:
            return float("inf")
        used = self.used()
        names = ("stroke", "velocity", "road")
        return max(used[k] / float(getattr(limits, k)) for k in names)


def run_all(models: Mapping[str, Model], program: Program, dt: float) -> dict[str, Run]:
    """A program run with each model, from rest, for its duration; cars all, or dampers all."""
    t = times(program.duration, dt)
    road, duty = program.signals(t)
    if next(iter(models.values())).is_vehicle:
        runs = {name: simulate(model, dt, road, duty) for name, model in models.items()}
        return {name: _read(models[name], dt, _contract(out)) for name, out in runs.items()}
    imposed = _imposed(program, t, duty)
    return {name: _machine(model, imposed, t, road, duty) for name, model in models.items()}


def _read(model: Model, dt: float, channels: dict[str, Array]) -> Run:
    """A run whose channels are as the sensors of a model report them."""
    gain_x, offset_x, gain_v, _, offset_v = (float(c) for c in reading(model))
    return Run(dt, channels, (gain_x, offset_x), (gain_v, offset_v))


def _contract(out: dict[str, Array]) -> dict[str, Array]:
    """Only the contract's channels."""
    return {name: y for name, y in out.items() if name != "tyre_deflection"}


def _imposed(program: Program, t: Array, duty: Array) -> Motion:
    """Motion and duty of a damper in the machine, on a finer grid than the samples."""
    dt = float(t[1] - t[0]) / FINER
    fine = (t[0] + dt * np.arange((t.size - 1) * FINER + 1)).astype(float)
    below, here, above = (program.signals(fine + k * EPSILON)[0] for k in (-1, 0, 1))
    v = -(above - below) / (2.0 * EPSILON)
    a = -(above - 2.0 * here + below) / EPSILON**2
    return motion(dt, -here, v, np.repeat(duty, FINER)[: fine.size], a)


def _machine(model: Model, imposed: Motion, t: Array, road: Array, duty: Array) -> Run:
    """One damper along an imposed motion, as its sensors report it."""
    gain_x, offset_x, gain_v, _, offset_v = reading(model)
    x, v = (imposed.x - offset_x) / gain_x, (imposed.v - offset_v) / gain_v
    force = predict(model, replace(imposed, x=x, v=v))[::FINER]
    channels = {
        "t": t, "road": road, "deflection": x[::FINER], "deflection_velocity": v[::FINER],
        "duty": duty, "damper_force": force, "sprung_acceleration": np.zeros(t.size),
        "unsprung_acceleration": -imposed.a[::FINER],
    }  # fmt: skip
    return _read(model, float(t[1] - t[0]), channels)
