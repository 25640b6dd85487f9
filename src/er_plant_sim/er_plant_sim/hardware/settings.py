"""Parameters of the bridge node, and the bridge they mean. No ROS here."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from er_models.errors import InputError
from er_models.files import load_model
from er_models.own import catalogue_with
from er_models.program import Program, load_program, resolve
from er_ros_common.common_parameters import NodeParameters, injection_allowed
from er_ros_common.parameter_table import REQUIRED, param

from er_plant_sim.build import LONGEST
from er_plant_sim.duty_gate import Gate
from er_plant_sim.hardware.bridge import Bridge, Sources
from er_plant_sim.hardware.calibration import load_calibration
from er_plant_sim.hardware.link import Address

WIRES = ("serial", "udp")
BLOCK = 64
"""Ticks of a program that are computed at once."""


@dataclass(frozen=True, kw_only=True)
class BridgeParameters(NodeParameters):
    """Every parameter of the bridge."""

    link: str = param(REQUIRED, text="wire to the device: serial:PORT[@BAUD] or udp:HOST:PORT")
    calibration_file: str = param(REQUIRED, text="calibration of the device's channels")
    enable_fault_injection: bool = injection_allowed()
    model_file: str = param(REQUIRED, text="model of the vehicle; its rig block limits the duty")
    effects_from: tuple[str, ...] = param((), text="Python files with own effects that it uses")
    program_file: str = param("", text="program of road and duty; needed where they come from it")
    duration: float = param(
        -1.0, unit="s", low=-1.0, high=1e6, text="-1: as the program says, 0: no end"
    )
    seed: int = param(-1, low=-1, high=2**31, text="of road and duty; -1: the program's")
    rate: float = param(200.0, unit="Hz", low=10.0, high=2000.0, text="samples per second")
    duty_source: str = param("topic", choices=("program", "topic"), text="who says the duty")
    road_source: str = param(
        "device",
        choices=("program", "device"),
        text="who moves the road: program asks the device to",
    )
    safe_duty: float = param(REQUIRED, low=0.0, high=1.0, text="duty without a fresh command")
    command_timeout: float = param(
        0.045, unit="s", low=0.005, high=1.0, text="age at which a command is no longer held"
    )
    duty_slew: float = param(
        0.0, unit="1/s", low=0.0, high=1e4, text="fastest change of the duty; 0: no limit"
    )
    silence: float = param(
        0.05, unit="s", low=0.005, high=1.0, text="time without sample after which the rig is lost"
    )
    noise_force: float = param(
        0.0,
        unit="N",
        low=0.0,
        high=1e3,
        name="noise.force",
        text="standard deviation of the force sensor",
    )
    wait_for: tuple[int, ...] = param(
        (0,) * 5,
        length=5,
        low=0,
        high=100,
        text="subscribers to wait for of acceleration, deflection, force, road, applied duty",
    )
    wait_for_nodes: tuple[str, ...] = param(
        (), text="nodes of the own namespace to wait for until they say that they are ready"
    )
    start_timeout: float = param(
        60.0, unit="s", low=0.0, high=600.0, text="how long to wait for them at most"
    )


@dataclass(frozen=True, eq=False)
class Built:
    """Bridge, its wire, digest of the model, and the ticks after which it ends (0: never)."""

    bridge: Bridge
    address: Address
    model_id: str
    ticks: int


def build(p: BridgeParameters, sources: Sources) -> Built:
    """The bridge of these parameters.

    Raises:
        InputError: A file cannot be used, or a parameter it needs was not given.
    """
    address = Address(p.link, WIRES, "parameters: link")
    model = load_model(p.model_file, catalogue_with(p.effects_from))
    gate = Gate(
        duty_min=model.rig.get("duty_min", 0.0),
        duty_max=model.rig.get("duty_max", 1.0),
        safe_duty=p.safe_duty,
        timeout=p.command_timeout,
        slew=p.duty_slew or math.inf,
    )
    program = None if not p.program_file else _program(p)
    if program is None and "program" in (p.duty_source, p.road_source):
        raise InputError("parameters", "program_file", "a program of the duty or road", "nothing")
    duty = road = None
    if program is not None:
        if p.road_source == "program":
            bounded = replace(program, duration=min(program.duration or LONGEST, LONGEST))
            program = replace(program, road=resolve(bounded, model, 1.0 / p.rate).road)
            road = _signal(program, p.rate, 0)
        duty = _signal(program, p.rate, 1) if p.duty_source == "program" else None
    bridge = Bridge(
        calibration=load_calibration(p.calibration_file),
        gate=gate,
        period=round(1e9 / p.rate),
        silence=p.silence,
        sources=sources,
        duty=duty,
        road=road,
    )
    duration = program.duration if program is not None else max(p.duration, 0.0)
    return Built(bridge, address, model.digest(), round(duration * p.rate))


def _program(p: BridgeParameters) -> Program:
    program = load_program(p.program_file)
    if program.moves != "wheel":
        expected = "wheel (a program for a test machine cannot drive a car)"
        raise InputError(p.program_file, "moves", expected, program.moves)
    program = program if p.duration < 0.0 else replace(program, duration=p.duration)
    return program if p.seed < 0 else replace(program, seed=p.seed)


def _signal(program: Program, rate: float, which: int) -> Callable[[int], float]:
    """Road (0) or duty (1) of a program from a tick on."""
    unscaled = {k: v for k, v in program.road.items() if k != "peak_velocity"}
    program = replace(program, road=unscaled)

    @lru_cache(maxsize=4)
    def block(number: int) -> tuple[float, ...]:
        ticks = np.arange(number * BLOCK, (number + 1) * BLOCK, dtype=np.float64)
        signal = program.signals(np.asarray(ticks / rate, np.float64))[which]
        return tuple(signal.tolist())

    block(0)  # what is compiled or read at first use must not hold up the first sample
    return lambda tick: block(tick // BLOCK)[tick % BLOCK]
