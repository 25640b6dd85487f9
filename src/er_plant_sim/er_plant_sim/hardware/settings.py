"""Parameters of the bridge node, and the bridge they mean. No ROS here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from er_common.parameter_table import REQUIRED, param, tuning
from er_models.errors import InputError
from er_models.files import load_model
from er_models.model import Array
from er_models.own import effects
from er_models.program import Program, load_program, times

from er_plant_sim.hardware import frame
from er_plant_sim.hardware.bridge import Bridge, Sources
from er_plant_sim.hardware.calibration import load_calibration
from er_plant_sim.hardware.link import HOST_WIRES, Address
from er_plant_sim.rig_parameters import (
    LONGEST,
    RigParameters,
    for_this_run,
    gate,
    of_a_wheel,
    scaled,
)

BLOCK = 64
"""Ticks of a program that are computed at once."""


@dataclass(frozen=True, kw_only=True)
class BridgeParameters(RigParameters):
    """Every parameter of the bridge."""

    link: str = param(
        REQUIRED, text="connection to the device: serial:PORT[@BAUD] or udp:HOST:PORT"
    )
    calibration_file: str = param(
        REQUIRED, text="file with the calibration of the device's channels"
    )
    key_file: str = param(
        "",
        text="key shared with the device: a file, none (no authentication), or empty: none over a serial port, "
        "the user's own over UDP",
    )
    road_source: str = param(
        "device",
        choices=("program", "device"),
        text="who decides how the road moves: the device itself, or the program",
    )
    silence: float = tuning(
        0.05,
        unit="s",
        low=0.005,
        high=1.0,
        text="time without a sample after which the rig counts as lost",
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
    address = Address(p.link, HOST_WIRES, "parameters: link")
    model = load_model(p.model_file, effects(p.effects_from))
    program = _program(p) if p.program_file else None
    if program is None and "program" in (p.duty_source, p.road_source):
        raise InputError("parameters", "program_file", "a program of the duty or road", "nothing")
    duty = road = None
    if program is not None:
        if p.road_source == "program":
            program = _reachable(p, *scaled(program, model, 1.0 / p.rate))
            road = _signal(program, p.rate, Program.heights)
        duty = _signal(program, p.rate, Program.duties) if p.duty_source == "program" else None
    bridge = Bridge(
        calibration=load_calibration(p.calibration_file),
        gate=gate(p, model),
        period=round(1e9 / p.rate),
        silence=p.silence,
        sources=sources,
        duty=duty,
        road=road,
    )
    duration = program.duration if program is not None else max(p.duration, 0.0)
    return Built(bridge, address, model.digest(), round(duration * p.rate))


def _program(p: BridgeParameters) -> Program:
    return for_this_run(p, of_a_wheel(p, load_program(p.program_file)))


def _reachable(p: BridgeParameters, program: Program, heights: Array) -> Program:
    """The program, if the wire can carry its road; heights: those that are known [m], (n,).

    Raises:
        InputError: It goes too high or too low, as far as it is looked at.
    """
    if not heights.size:
        heights = program.heights(times(min(program.duration or LONGEST, LONGEST), 1.0 / p.rate))
    peak, reach = float(np.abs(heights).max()), frame.ROAD_REACH * frame.ROAD_UNIT
    if peak <= reach:
        return program
    expected = f"heights within {reach:.3f} m: the wire carries no more"
    raise InputError(p.program_file, "road", expected, f"{peak:.4g} m")


def _signal(
    program: Program, rate: float, which: Callable[[Program, Array], Array]
) -> Callable[[int], float]:
    """Road or duty of a program from a tick on."""
    unscaled = {k: v for k, v in program.road.items() if k != "peak_velocity"}
    program = replace(program, road=unscaled)

    @lru_cache(maxsize=4)
    def block(number: int) -> tuple[float, ...]:
        ticks = np.arange(number * BLOCK, (number + 1) * BLOCK, dtype=np.float64)
        signal = which(program, np.asarray(ticks / rate, np.float64))
        return tuple(signal.tolist())

    block(0)  # what is compiled or read at first use must not hold up the first sample
    return lambda tick: block(tick // BLOCK)[tick % BLOCK]
