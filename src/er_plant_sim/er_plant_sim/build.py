"""From the parameters of the plant node to the rig they describe."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from er_models.belonging import check_belonging
from er_models.errors import InputError
from er_models.files import load_model
from er_models.interlude import begun, ended
from er_models.model import Model
from er_models.own import effects
from er_models.program import SCHEMA, Program, load_program, parse_program
from er_models.simulation import gone_over, substeps

from er_plant_sim.noise import Errors, Noise
from er_plant_sim.rig import Rig, RigState
from er_plant_sim.rig_parameters import for_this_run, gate, of_a_wheel, planned, scaled
from er_plant_sim.settings import PlantParameters, SensorErrors, program_values
from er_plant_sim.simulator import damper_replaced, simulator


def build(p: PlantParameters) -> Rig:
    """The rig of these parameters.

    Raises:
        InputError: A file cannot be used, or parameters contradict one another.
    """
    _consistent(p)
    model, dt = load_plant_model(p), 1.0 / p.rate
    program = of_a_wheel(p.program_file, load_given_program(p))
    noise = Noise(sensor_errors(p, "noise"), sensor_errors(p, "bias"), program.seed)
    # a road scaled to a peak velocity means the vehicle as it is known, not what is hidden in it
    known = load_model(p.model_file, effects(p.effects_from))
    program, heights = scaled(program, known, dt)
    programmed = p.duty_source == "program"
    rig = Rig(simulator(model, dt, noise), gate(p, model), program, programmed, heights)
    return with_planned(p, rig, 0) if p.planned_file else rig


def with_damper(p: PlantParameters, rig: Rig, state: RigState) -> tuple[Rig, RigState]:
    """The rig with the damper that the parameters name, at the same instant of its drive; raises as `build`."""
    made = simulator(load_plant_model(p), rig.dt, rig.sim.noise)
    car = gone_over(made.plant, state.sim.plant)
    return replace(rig, sim=made), RigState(state.sim._replace(plant=car), state.gate)


def with_planned(p: PlantParameters, rig: Rig, tick: int) -> Rig:
    """The rig whose drive has the planned run from a tick on, or without one ends it there; raises as `build`."""
    t = tick * rig.dt
    if not p.planned_file:
        return replace(rig, program=ended(rig.program, t))
    known = load_model(p.model_file, effects(p.effects_from))
    run = planned(p, known, rig.sim.plant.model)
    ahead = substeps(rig.dt) * tick + 1
    return replace(rig, program=begun(rig.program, run, t), known=rig.known[:ahead])


def load_plant_model(p: PlantParameters) -> Model:
    """The vehicle, with the damper of another file where one is given; both may use the own effects."""
    return car(p.model_file, p.damper_file, p.effects_from)


def car(model_file: str, damper_file: str, effects_from: Sequence[str] = ()) -> Model:
    """The vehicle of a file with the damper of another one, "" for its own.

    Raises:
        InputError: A file cannot be used, or the damper does not belong to this car.
    """
    catalogue = effects(effects_from)
    vehicle = load_model(model_file, catalogue)
    if damper_file:
        vehicle = damper_replaced(vehicle, load_model(damper_file, catalogue))
    if vehicle.is_vehicle:  # else `prepare` says so
        check_belonging(vehicle)
    return vehicle


def load_given_program(p: PlantParameters) -> Program:
    """The program of the file, with what the parameters say on top."""
    road, duty = program_values(p, "road"), program_values(p, "duty")
    base = load_program(p.program_file) if p.program_file else None
    if base is None and "kind" not in road:
        expected = "a program file, or road.kind"
        raise InputError("parameters", "program_file", expected, "neither")
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "name": base.name if base else "parameters",
        "duration": base.duration if base else 0.0,
        "seed": base.seed if base else 0,
        "moves": base.moves if base else "wheel",
        "road": _merged(base.road if base else {}, road),
        "duty": _merged(base.duty if base else {"kind": "constant"}, duty),
    }
    return for_this_run(p, parse_program(document, Path("parameters")))


def _merged(base: Any, given: dict[str, Any]) -> dict[str, Any]:
    """Settings of the base with the given ones on top; of another kind nothing is kept."""
    listed = {k: list(v) if isinstance(v, tuple) else v for k, v in given.items()}
    return listed if "kind" in listed else {**base, **listed}


def sensor_errors(p: SensorErrors, prefix: str) -> Errors:
    """Standard deviations (prefix `noise`) or constant errors (`bias`) of all sensors."""
    names = ("sprung", "unsprung", "deflection", "velocity", "force")
    return Errors(*(getattr(p, f"{prefix}_{name}") for name in names))


def _consistent(p: PlantParameters) -> None:
    """Refuse combinations that cannot run."""
    unpaced = p.rate_factor == 0.0
    if unpaced and not (p.mode == "lockstep" and p.duty_source == "topic"):
        expected = "above 0 (0 only in lockstep with duty_source topic)"
        raise InputError("parameters", "rate_factor", expected, "0")
    if p.mode == "realtime" and p.rate_factor != 1.0:
        found = f"{p.rate_factor:g}"
        raise InputError("parameters", "rate_factor", "1 in mode realtime", found)
