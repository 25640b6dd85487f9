"""The testbench in simulation: a program driven by a vehicle model, read by the sensors of the rig."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from er_models.errors import InputError
from er_models.model import Model
from er_models.program import Program, resolve, times
from er_models.simulate import simulate
from er_models.yaml_file import read_yaml

from er_model_lab.record import CHANNELS, Record

DT = 0.005
"""Sample time of the testbench [s], thesis section 1.3."""
_NOISE = {
    "sprung_acceleration": "noise.sprung_acceleration",
    "unsprung_acceleration": "noise.unsprung_acceleration",
    "deflection": "noise.deflection",
    "deflection_velocity": "noise.deflection_velocity",
    "damper_force": "noise.force",
}
"""Channel to the parameter of the plant node that holds its standard deviation."""


def sensor_noise(path: Path) -> dict[str, float]:
    """Standard deviation [SI] of every noisy channel, from the parameters of the simulated rig.

    Raises `InputError` for a file without them.
    """
    found: Any = read_yaml(path, "a parameter file of the plant")
    for key in ("/**", "ros__parameters"):
        found = found.get(key) if isinstance(found, Mapping) else None
    if not isinstance(found, Mapping):
        raise InputError(path, "/**.ros__parameters", "parameters of the plant", "nothing")
    deviations = {}
    for channel, name in _NOISE.items():
        value = found.get(name)
        if not isinstance(value, int | float) or isinstance(value, bool) or not value >= 0.0:
            raise InputError(path, name, "a standard deviation, 0 or more", repr(value))
        deviations[channel] = float(value)
    return deviations


def measure(vehicle: Model, program: Program, noise: Mapping[str, float], seed: int) -> Record:
    """One run of a program on the simulated testbench at 200 Hz, with white noise on every sensor.

    noise: standard deviation [SI] by channel; seed: of the noise, the road has the program's own.
    """
    program = resolve(program, vehicle, DT)
    t = times(program.duration, DT)
    run = simulate(vehicle, DT, *program.signals(t))
    random = np.random.default_rng(seed)
    channels = {
        name: run[name] + noise.get(name, 0.0) * random.standard_normal(t.size)
        for name in CHANNELS
        if name in run
    }
    return Record(program.name, t, channels, source=program.source)
