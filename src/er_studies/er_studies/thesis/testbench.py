"""The testbench in simulation: a program driven by a vehicle model, read by the sensors of its rig."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from er_model_lab.planning.limits import sensors_of
from er_model_lab.planning.simulated_decision import measured
from er_model_lab.planning.virtual_rig import Run
from er_models.constants import SAMPLE_TIME as DT
from er_models.model import Model
from er_models.program import Program, resolve
from er_models.simulation import simulate
from er_records.record import CHANNELS, Record


def measure(vehicle: Model, program: Program, seed: int) -> Record:
    """One run of a program on the simulated testbench at 200 Hz, with the white noise of the model's rig.

    seed: of the noise; the road has the program's own. Raises `InputError` for a model without a car.
    """
    program = resolve(program, vehicle, DT)
    run = simulate(vehicle, DT, *program.ride(DT))
    made = Run(DT, {name: run[name] for name in ("t", *CHANNELS) if name in run})
    sensors, _ = sensors_of(vehicle, None)
    record = measured(made, sensors, np.random.default_rng(seed), program.name)
    return replace(record, source=program.source)
