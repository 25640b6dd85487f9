"""What an observer is worth: simulated drives with sensor noise, and the error of its force.

The plant may be another model than the one the gains were made for: a hidden effect, other
parameters.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from er_models.constants import SAMPLE_TIME as DT
from er_models.model import Array, Model
from er_models.program import Program, resolve, times
from er_models.simulation import simulate

from er_observers.gains import Gains
from er_observers.observers.status import Status
from er_observers.running.runtime import Estimate, Sample, start, step


@dataclass(frozen=True)
class Scenario:
    """A drive and how wrong things are.

    noise: of both accelerometers [m/s2]; deflection_noise: of that sensor where it is used [m];
    deflection_error: of the start [m], None for the observer's own start; after: time from which
    errors count [s].
    """

    name: str
    program: Program
    noise: float = 0.025
    deflection_noise: float = 1e-4
    deflection_error: float | None = 0.01
    after: float = 2.0


class Score(NamedTuple):
    """Error of the force after the settling time.

    nrmse: rms over the range of the true force (3.79); rmse and largest [N]; first_ok: time of the
    first OK [s], None for never; weak: share of WEAK estimates; test_ratio: largest.
    """

    scenario: str
    nrmse: float
    rmse: float
    largest: float
    first_ok: float | None
    weak: float
    test_ratio: float


_CHIRP: Mapping[str, object] = {"kind": "chirp", "sweep": 15.0}
_ISO: Mapping[str, object] = {"kind": "iso8608", "peak_velocity": 0.15}
_SWITCHED: Mapping[str, object] = {"kind": "square", "frequency": 4.3}
_SLOW = {"kind": "sine", "mean": 0.5, "amplitude": 0.5}
SCENARIOS = tuple(
    Scenario(name, Program(road, duty, 15.0, seed))
    for name, road, duty, seed in (
        ("chirp, duty 0.1", _CHIRP, {"kind": "constant", "level": 0.1}, 0),
        ("ISO C, duty 0", _ISO, {"kind": "constant", "level": 0.0}, 1),
        ("ISO C, duty 0.3", _ISO, {"kind": "constant", "level": 0.3}, 1),
        ("ISO C, slow sine 0 to 1", _ISO, _SLOW, 2),
        ("ISO C, switched 0 to 0.3", _ISO, {**_SWITCHED, "high": 0.3}, 3),
        ("ISO C, switched 0 to 1", _ISO, {**_SWITCHED, "high": 1.0}, 3),
        ("ISO C, random steps", _ISO, {"kind": "steps"}, 4),
    )
)
"""Roads of the thesis's chapters 3 to 5 at the rig's limit of 0.15 m/s, duties as they come."""


def evaluate(plant: Model, gains: Gains, scenario: Scenario) -> Score:
    """Simulate the plant, add noise, run the observer, compare with the true force."""
    program = resolve(scenario.program, plant, DT)
    t = times(program.duration, DT)
    record = simulate(plant, DT, *program.ride(DT))
    estimates = replay(gains, noisy(record, scenario), _first(gains, record, scenario))
    force = np.array([e.force for e in estimates])
    status = np.array([e.status for e in estimates])
    late = t >= scenario.after
    error, true = (force - record["damper_force"])[late], record["damper_force"][late]
    rmse = float(np.sqrt(np.mean(error**2)))
    ok = np.flatnonzero(status == Status.OK)
    return Score(
        scenario.name,
        nrmse=rmse / float(np.ptp(true)),
        rmse=rmse,
        largest=float(np.abs(error).max()),
        first_ok=float(t[ok[0]]) if ok.size else None,
        weak=float(np.mean(status == Status.WEAK)),
        test_ratio=max(e.test_ratio for e in estimates),
    )


def noisy(record: Mapping[str, Array], scenario: Scenario) -> dict[str, Array]:
    """The record with noise on what the sensors read, seeded by the scenario's program."""
    random = np.random.default_rng([scenario.program.seed, 1])
    sizes = {"sprung_acceleration": scenario.noise, "unsprung_acceleration": scenario.noise}
    sizes["deflection"] = scenario.deflection_noise
    noise = {
        name: size * random.standard_normal(record[name].shape)
        for name, size in sizes.items()
        if name in record
    }
    return {name: values + noise.get(name, 0.0) for name, values in record.items()}


def replay(gains: Gains, record: Mapping[str, Array], x: Array | None = None) -> list[Estimate]:
    """Estimates of the observer on a record with the contract's columns; x (n,): known start."""
    columns = ["t", "sprung_acceleration", "unsprung_acceleration", "duty"]
    columns += ["deflection"] if gains.sees_deflection else []
    samples = [Sample(*row) for row in zip(*(record[c].tolist() for c in columns), strict=True)]
    state = start(gains, samples[0], x)
    estimates = [state.estimate]
    for sample in samples[1:]:
        state, estimate = step(gains, state, sample)
        estimates.append(estimate)
    return estimates


def _first(gains: Gains, record: Mapping[str, Array], scenario: Scenario) -> Array | None:
    """The true first state with a wrong deflection, or None."""
    if scenario.deflection_error is None:
        return None
    x = np.zeros(gains.form.n)
    x[0] = record["deflection"][0] + scenario.deflection_error
    x[1], x[2] = record["deflection_velocity"][0], record["tyre_deflection"][0]
    return x
