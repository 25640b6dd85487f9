"""Parameters of the bridge node, and the bridge they mean. No ROS here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from er_common.parameter_table import REQUIRED, param, tuning
from er_models.errors import InputError
from er_models.files import load_model
from er_models.interlude import Drive, Interlude, begun, ended
from er_models.model import Array
from er_models.own import effects
from er_models.program import LONGEST, Program, load_program, times

from er_plant_sim.hardware import frame
from er_plant_sim.hardware.bridge import Bridge, Sources
from er_plant_sim.hardware.calibration import load_calibration
from er_plant_sim.hardware.link import HOST_WIRES, Address
from er_plant_sim.rig_parameters import (
    RigParameters,
    for_this_run,
    gate,
    of_a_wheel,
    planned,
    scaled,
)

STILL = {"kind": "flat"}
"""The road of a drive whose device moves it."""
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
    """Bridge, its wire, digest of the model, and what is driven as far as a program says it."""

    bridge: Bridge
    address: Address
    model_id: str
    drive: Drive


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
    if program is None:
        program = Program(STILL, {"kind": "constant"}, max(p.duration, 0.0), 0)
    elif p.road_source == "program":
        program = _reachable(p.program_file, *scaled(program, model, 1.0 / p.rate), 1.0 / p.rate)
    else:
        program = replace(program, road=STILL)
    duty, road = signals(p, program)
    bridge = Bridge(
        calibration=load_calibration(p.calibration_file),
        gate=gate(p, model),
        period=round(1e9 / p.rate),
        silence=p.silence,
        sources=sources,
        duty=duty,
        road=road,
    )
    return Built(bridge, address, model.digest(), program)


def with_planned(p: BridgeParameters, drive: Drive, seq: int) -> Drive:
    """The drive with the planned run from a sample on, or without one ended there; raises as `build`."""
    t = seq / p.rate
    if not p.planned_file:
        return ended(drive, t)
    model = load_model(p.model_file, effects(p.effects_from))
    run = planned(p, model, model)
    if p.road_source == "program":
        run = _reachable(p.planned_file, run, np.empty(0), 1.0 / p.rate)
    return begun(drive, run, t)


def _program(p: BridgeParameters) -> Program:
    return for_this_run(p, of_a_wheel(p.program_file, load_program(p.program_file)))


def _reachable(name: str, program: Program, heights: Array, dt: float) -> Program:
    """The program of a file, if the wire can carry its road; heights: those that are known [m], (n,); dt: [s].

    Raises:
        InputError: It goes too high or too low, as far as it is looked at.
    """
    if not heights.size:
        heights = program.heights(times(min(program.duration or LONGEST, LONGEST), dt))
    peak, reach = float(np.abs(heights).max()), frame.ROAD_REACH * frame.ROAD_UNIT
    if peak <= reach:
        return program
    expected = f"heights within {reach:.3f} m: the wire carries no more"
    raise InputError(name, "road", expected, f"{peak:.4g} m")


def signals(
    p: BridgeParameters, drive: Drive, tick: int = 0
) -> tuple[Callable[[int], float | None] | None, Callable[[int], float] | None]:
    """Duty and road of a drive, as `Bridge` has them; tick: the first that is asked for."""
    road = _signal(drive.heights, p.rate, tick) if p.road_source == "program" else None
    if p.duty_source == "program":
        return _signal(drive.duties, p.rate, tick), road
    if not isinstance(drive, Interlude):
        return None, road
    wanted = _signal(drive.duties, p.rate, tick)
    return lambda tick: wanted(tick) if drive.rules(tick / p.rate) else None, road


def _signal(which: Callable[[Array], Array], rate: float, tick: int) -> Callable[[int], float]:
    """Road or duty from a tick on."""

    @lru_cache(maxsize=4)
    def block(number: int) -> tuple[float, ...]:
        ticks = np.arange(number * BLOCK, (number + 1) * BLOCK, dtype=np.float64)
        return tuple(which(np.asarray(ticks / rate, np.float64)).tolist())

    block(tick // BLOCK)  # what is compiled or read at first use must not hold up a sample
    return lambda tick: block(tick // BLOCK)[tick % BLOCK]
