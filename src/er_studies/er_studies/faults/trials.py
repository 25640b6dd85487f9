"""Random closed-loop drives for the fault estimator: road, Skyhook, sensors with noise, a fault or a hidden effect."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from er_models.constants import SAMPLE_TIME as DT
from er_models.model import Array, Model
from er_models.program import parse_program, resolve
from er_models.simulation import initial_state, prepare, step
from er_observers.faults.sample import Sample

FAULTS = {"f1": "electrical_fault", "f2": "oil_leakage", "f3": "duct_deformation"}
"""Effect of each factor."""
_ROADS = ("iso8608", "bumps", "steps")
CLASSES = ("A", "B", "C", "D", "E")
COURSES = (*(f"iso8608 {c}" for c in CLASSES), "round bumps", "sharp bumps", "tone", "chirp")
"""Roads that are drawn in full: shape and speed besides the seed."""
_PART = 1.5
"""Time between two steps of the road [s]."""


@dataclass(frozen=True)
class Trial:
    """One drive; everything random follows from the seed.

    left: what the fault leaves, by factor, from `fault_time` [s] on. hidden: effects that the model does not know,
    from the start. spread: every parameter of the plant is off by a random share within it. duty: held instead of
    Skyhook's. still: the car stands. straight: the road is so between samples, a special case. road: one of the kinds
    that `_spec` knows or of `COURSES`, drawn where it is empty. peak: deflection velocity that the road gives the
    passive car [m/s], drawn near the rig's where it is 0. grows: time in which the fault grows [s].
    """

    seed: int
    left: Mapping[str, float] = field(default_factory=dict)
    fault_time: float = 8.0
    duration: float = 16.0
    hidden: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    spread: float = 0.0
    duty: float | None = None
    still: bool = False
    road: str = ""
    straight: bool = False
    peak: float = 0.0
    grows: float = 0.0


class Drive(NamedTuple):
    """What the sensors said, sample by sample, and the true motion (n, 2): deflection, velocity."""

    samples: list[Sample]
    motion: Array


def drive(trial: Trial, model: Model) -> Drive:
    """The record of a trial with a model's car; the noise is that of its rig, the force sensor's included."""
    random = np.random.default_rng([trial.seed, 0])
    plant = _plant(trial, model, random)
    road = _road(trial, model, random)
    duties = model.rig.get("duty_min", 0.0), model.rig.get("duty_max", model.scales.duty)
    names = ("acceleration", "acceleration", "deflection", "velocity", "force")
    sizes = np.array([model.rig[f"{name}_noise"] for name in names])
    prepared = prepare(plant, DT)
    ways = road[1:].reshape(-1, prepared.n_sub)
    noise = sizes * random.standard_normal((len(ways) + 1, 5))
    state = initial_state(prepared, float(road[0]), duties[0])
    samples, motion, duty = [], np.zeros((len(ways) + 1, 2)), duties[0]
    for k, way in enumerate(ways, start=1):
        state, out = step(prepared, state, (way, duty))
        body, relative = state.q[1], state.q[1] - state.q[3]
        duty = duties[int(body * relative >= 0.0)] if trial.duty is None else trial.duty
        e = noise[k]
        samples.append(Sample(
            k * DT, out.sprung_acceleration + e[0], out.unsprung_acceleration + e[1], out.deflection + e[2],
            out.deflection_velocity + e[3], duty, out.measured_force + e[4],
        ))  # fmt: skip
        motion[k] = state.q[0], relative
    return Drive(samples, motion[1:])


def _plant(trial: Trial, model: Model, random: np.random.Generator) -> Model:
    """The car with its fault, its hidden effects, and parameters that are off."""
    effects = {
        name: {q: v * random.uniform(1.0 - trial.spread, 1.0 + trial.spread) for q, v in values.items()}
        for name, values in model.effects.items()
    }  # fmt: skip
    plant = replace(model, effects=effects)
    for name, values in trial.hidden.items():
        plant = plant.with_effect(name, dict(values) or None)
    for factor, left in trial.left.items():
        values = {"f": left, "t_0": trial.fault_time, "t_r": trial.grows, "q": 0.0, "d": 0.5}
        plant = plant.with_effect(FAULTS[factor], values)
    return plant


def _road(trial: Trial, model: Model, random: np.random.Generator) -> Array:
    """Heights of the road [m], as of `Program.ride`: a random kind, scaled to the velocity of the rig."""
    kind = trial.road or str(random.choice(_ROADS, p=(0.5, 0.25, 0.25)))
    peak = random.uniform(0.8, 1.0) * model.rig.get("velocity_max", model.scales.velocity)
    spec = _course(kind, trial.duration, random) if kind in COURSES else _spec(kind, random)
    document = {
        "schema": "er_program 1", "duration": trial.duration, "seed": trial.seed,
        "road": {**spec, "peak_velocity": float(trial.peak or peak), "straight": DT * trial.straight},
        "duty": {"kind": "constant", "level": 0.0},
    }  # fmt: skip
    program = resolve(parse_program(document, Path("trial")), model, DT)
    height = program.ride(DT)[0]
    return np.zeros_like(height) if trial.still else height


def _spec(kind: str, random: np.random.Generator) -> dict[str, Any]:
    """A road of class C, bumps of a random length, or steps."""
    if kind == "bumps":
        length = float(random.uniform(4.0, 10.0))
        shape = {"height": 0.01, "length": length, "spacing": 2.0 * length, "speed": 30.0}
        return {"kind": "bumps", **shape}
    if kind == "steps":
        part = {"kind": "step", "height": 0.01, "time": 0.4, "rise": 0.03, "seconds": _PART}
        return {"kind": "sequence", "fade": 0.1, "parts": [part]}
    return {"kind": "iso8608", "road_class": "C"}


def _course(kind: str, duration: float, random: np.random.Generator) -> dict[str, Any]:
    """A road of `COURSES` with a random speed, length or frequency."""
    speed = float(random.uniform(20.0, 100.0)) / 3.6
    if kind.startswith("iso8608"):
        return {"kind": "iso8608", "road_class": kind[-1], "speed": speed}
    if kind.endswith("bumps"):
        length = speed / float(random.uniform(2.0, 8.0))
        edge = 0.5 if kind.startswith("round") else float(random.uniform(0.03, 0.2))
        spacing = length * float(random.uniform(1.0, 6.0))
        shape = {"height": 0.01, "length": length, "spacing": spacing, "speed": speed}
        return {"kind": "bumps", **shape, "edge": edge}
    if kind == "tone":
        frequency = float(np.exp(random.uniform(math.log(1.0), math.log(20.0))))
        return {"kind": "sine", "amplitude": 0.005, "frequency": frequency}
    high = float(random.uniform(10.0, 25.0))
    return {"kind": "chirp", "amplitude": 0.004, "f0": 0.5, "f1": high, "sweep": duration}


def faults(factor: str, seed: int, number: int, spread: float = 0.0) -> Iterator[Trial]:
    """Random steps of one factor (`f1`, `f2`, `f3`), or of all three (`combined`); spread: see `Trial`."""
    for i in range(number):
        random = np.random.default_rng([seed, i, 1])
        names = FAULTS if factor == "combined" else (factor,)
        left = {name: float(random.uniform(0.3, 0.9)) for name in names}
        begun = float(random.uniform(6.0, 10.0))
        yield Trial(seed * 1000 + i, left, fault_time=begun, spread=spread)
