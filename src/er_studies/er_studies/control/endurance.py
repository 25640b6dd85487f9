"""A long ride with faults that come and go, each at its own pace: whether the loop stays stable, and what it does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from er_models.constants import SAMPLE_TIME as DT
from er_models.model import Array, Model, Values
from er_models.program import Program, resolve

from er_studies.control.closed_loop import Sensors, drive, known
from er_studies.control.rivals import passive
from er_studies.control.run import Setup, WatchOf

FAULTS: Values = {
    "electrical_fault": {"f": 0.5, "t_0": 5.0, "t_r": 0.0, "q": 1.0 / 53.0, "d": 0.25},
    "oil_leakage": {"f": 0.6, "t_0": 25.0, "t_r": 2.0, "q": 1.0 / 71.0, "d": 0.3},
    "duct_deformation": {"f": 0.7, "t_0": 50.0, "t_r": 1.0, "q": 1.0 / 97.0, "d": 0.25},
}
"""Periods without a common factor: alone and together, in every order."""
WORST = 1.2
"""Peak deflection over the passive car's from which on the loop is called unstable."""


@dataclass(frozen=True)
class Ride:
    """Length [s], greatest duty, latency in samples, seed."""

    seconds: float
    duty_max: float = 1.0
    latency: int = 0
    seed: int = 1


class Verdict(NamedTuple):
    """What the ride was like.

    stable: all numbers finite and the peak within `WORST` of the passive car's; peak, rms: deflection over the passive
    car's; changes: of mode; adapted, safe: share of the time; error: rms of each factor in use (3,).
    """

    stable: bool
    peak: float
    rms: float
    changes: int
    adapted: float
    safe: float
    error: tuple[float, float, float]


def ride(
    setup: Setup, watch: WatchOf, r: Ride, tick: Callable[[int, int], None] | None = None
) -> Verdict:
    """Drive the controller and the passive car over the same road with the same faults.

    tick: told the seconds driven, of those that both drive.
    """
    car = _faulty(setup.model)
    program = Program(
        {"kind": "iso8608", "road_class": "C", "peak_velocity": 0.15},
        {"kind": "constant", "level": 0.0}, r.seconds, r.seed,
    )  # fmt: skip
    road = resolve(program, setup.model, DT).ride(DT)[0]
    p = replace(setup.parameters, u_max=r.duty_max, latency=r.latency * DT)
    sensors, source = Sensors(latency=r.latency), watch(setup.model, car)
    ours = drive(car, road, DT, setup.built(p), source, sensors, r.seed, _seconds(r, tick, 0))
    untold = known(setup.model, car)  # a passive car's faults need no estimate
    second = _seconds(r, tick, 1)
    bare = drive(car, road, DT, passive(p.u_min), untold, sensors, r.seed, second)
    return judge(ours, bare)


def judge(ours: dict[str, Array], bare: dict[str, Array]) -> Verdict:
    """Verdict on two records of the same road."""
    finite = all(bool(np.isfinite(values).all()) for values in ours.values())
    x, other = ours["deflection"], bare["deflection"]
    peak = float(np.abs(x).max() / np.abs(other).max())
    error = np.sqrt(np.mean((ours["believed"] - ours["left"]) ** 2, axis=0))
    modes = ours["safe"] + 2.0 * ours["adapted"]
    return Verdict(
        finite and peak <= WORST, peak, float(np.std(x) / np.std(other)),
        int(np.count_nonzero(np.diff(modes))), float(ours["adapted"].mean()), float(ours["safe"].mean()),
        (float(error[0]), float(error[1]), float(error[2])),
    )  # fmt: skip


def _seconds(
    r: Ride, tick: Callable[[int, int], None] | None, before: int
) -> Callable[[float], None] | None:
    """What a car that drives after so many others tells of its time."""
    if tick is None:
        return None
    return lambda t: tick(round(t + before * r.seconds), round(2 * r.seconds))


def _faulty(model: Model) -> Model:
    """The car with all faults, coming and going."""
    for name, values in FAULTS.items():
        model = model.with_effect(name, values)
    return model
