"""What the plant and the bridge to a real rig have in common: parameters, limits of the duty, program. No ROS here."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from er_common.common_parameters import FramedParameters, injection_allowed
from er_common.parameter_table import REQUIRED, param, tuning
from er_models.constants import SAMPLE_RATE
from er_models.errors import InputError
from er_models.interlude import check_run
from er_models.model import Array, Model
from er_models.program import LONGEST, Program, load_program, resolved
from er_models.seed import OF_A_PLANT

from er_plant_sim.duty_gate import Gate


@dataclass(frozen=True, kw_only=True)
class RunParameters(FramedParameters):
    """Parameters of a run, of whatever publishes measurements and takes duties."""

    effects_from: tuple[str, ...] = param(
        (), text="Python files with own effects that the models use"
    )
    program_file: str = param("", text="file with the program of road and duty")
    duration: float = param(
        -1.0,
        unit="s",
        low=-1.0,
        high=1e6,
        text="length of the run; -1: as the program says, 0: no end",
    )
    seed: int = param(
        -1, low=-1, high=OF_A_PLANT, text="seed of everything random; -1: the program's"
    )
    rate: float = param(SAMPLE_RATE, unit="Hz", low=10.0, high=2000.0, text="samples per second")
    duty_source: str = param(
        "topic", choices=("program", "topic"), text="where the duty comes from"
    )
    safe_duty: float = tuning(
        REQUIRED, low=0.0, high=1.0, text="duty while there is no fresh command"
    )
    command_timeout: float = tuning(
        0.045, unit="s", low=0.005, high=1.0, text="age at which a command is no longer held"
    )
    duty_slew: float = tuning(
        0.0, unit="1/s", low=0.0, high=1e4, text="fastest change of the duty; 0: no limit"
    )
    noise_force: float = param(
        0.0,
        unit="N",
        low=0.0,
        high=1e3,
        name="noise.force",
        text="standard deviation of the noise of the force",
    )


@dataclass(frozen=True, kw_only=True)
class RigParameters(RunParameters):
    """Parameters of one corner: its model, who is waited for, and faults."""

    model_file: str = param(
        REQUIRED, text="model of the vehicle; the limits of the duty are in its section rig"
    )
    planned_file: str = tuning(
        "", text="program driven in the middle of the drive: its road and duty; empty ends it"
    )
    wait_for: tuple[int, ...] = param(
        (0,) * 5,
        length=5,
        low=0,
        high=100,
        text="subscribers to wait for, one number each: acceleration, deflection, force, road, applied duty",
    )
    wait_for_nodes: tuple[str, ...] = param(
        (), text="nodes of the own namespace to wait for until they say that they are ready"
    )
    start_timeout: float = param(
        60.0,
        unit="s",
        low=0.0,
        high=600.0,
        text="how long to wait for them at most; three times as long for one that still compiles",
    )
    enable_fault_injection: bool = injection_allowed()


def gate(p: RunParameters, model: Model) -> Gate:
    """Limits of the duty: the model's rig and the parameters."""
    return Gate(
        duty_min=model.rig.get("duty_min", 0.0),
        duty_max=model.rig.get("duty_max", 1.0),
        safe_duty=p.safe_duty,
        timeout=p.command_timeout,
        slew=p.duty_slew or math.inf,
    )


def tuned(p: RunParameters, before: Gate) -> Gate:
    """The same limits with what parameters say that may change; raises `InputError` where they contradict."""
    slew = p.duty_slew or math.inf
    return replace(before, safe_duty=p.safe_duty, timeout=p.command_timeout, slew=slew)


def for_this_run(p: RunParameters, program: Program) -> Program:
    """The program with duration and seed of the parameters."""
    if p.duration >= 0.0:
        program = replace(program, duration=p.duration)
    return program if p.seed < 0 else replace(program, seed=p.seed)


def of_a_wheel(name: str, program: Program) -> Program:
    """The program of a file, if it is one that drives a car.

    Raises:
        InputError: It moves something else.
    """
    if program.moves == "wheel":
        return program
    expected = "wheel (a program for a test machine cannot drive a car)"
    raise InputError(name, "moves", expected, program.moves)


def planned(p: RigParameters, known: Model, model: Model) -> Program:
    """The run that the parameters name, its road scaled for the car as it is known, kept within the rig of `model`.

    Raises:
        InputError: It cannot be read, moves no car, has no end, or takes this one too far.
    """
    dt = 1.0 / p.rate
    run, _ = scaled(of_a_wheel(p.planned_file, load_program(p.planned_file)), known, dt)
    check_run(run, model, dt, p.planned_file)
    return run


def scaled(program: Program, model: Model, dt: float) -> tuple[Program, Array]:
    """The program with its road scaled to the peak velocity it names, for this car at this step [s].

    And the road's heights [m] of the first ticks, as `Program.ride` has them, as many as are known by then.
    """
    bounded = replace(program, duration=min(program.duration or LONGEST, LONGEST))
    found, heights = resolved(bounded, model, dt)
    return replace(program, road=found.road), heights
