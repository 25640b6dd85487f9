"""What a record must hold to show each effect: regions of motion, duty and temperature, and how much of each.

Regions are shares of the rig's reach where a model says it, else of the reach of the data.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from er_models.catalogue import Catalogue
from er_models.effect import Effect
from er_records.record import Array, Record
from numpy.typing import NDArray

Mask = NDArray[np.bool_]

FEW_LEVELS = 3
"""Duties that must be held to see a law of the duty."""
LEVELS = 10
"""Parts of the duty's reach that count as different duties."""
STEP = 0.03
"""Change of the duty within a sample that is a step, as a share of its reach."""


@dataclass(frozen=True)
class Reach:
    """Largest |deflection| [m], |velocity| [m/s] and duty, and where they are known from."""

    deflection: float
    velocity: float
    duty: float
    known_from: str


@dataclass(frozen=True, eq=False)
class Course:
    """One record as the coverage sees it: all (n,), SI; NaN where a channel is absent."""

    dt: float
    x: Array
    v: Array
    u: Array
    theta: Array
    force: Array


@dataclass(frozen=True)
class Cell:
    """A region: what it is, how much of it an effect needs, in which unit, and how to count it."""

    name: str
    text: str
    need: float
    unit: str
    count: Callable[[Course, Reach], float]


def course_of(record: Record) -> Course:
    """The channels that coverage looks at; a deflection known only by its velocity is its integral."""
    n, dt = len(record), record.dt
    nothing = np.full(n, np.nan)
    v = record.channels.get("deflection_velocity", nothing)
    x = record.channels.get("deflection")
    if x is None:
        swing = np.cumsum(v - v.mean()) * dt
        x = swing - swing.mean()
    theta = record.channels.get("temperature", nothing)
    u = record.channels.get("duty", np.zeros(n))
    return Course(dt, x - _middle(x), v, u, theta, record.channels.get("damper_force", nothing))


def _middle(x: Array) -> float:
    """Middle of the stroke in use; zero stays zero where it lies inside."""
    low, high = float(np.min(x)), float(np.max(x))
    return 0.0 if low < 0.0 < high else 0.5 * (low + high)


def reach_of(courses: Sequence[Course]) -> Reach:
    """Reach of the data: the largest of each, a thousandth of the samples aside."""

    def peak(arrays: list[Array]) -> float:
        finite = np.abs(np.concatenate(arrays))
        finite = finite[np.isfinite(finite)]
        return float(np.quantile(finite, 0.999)) if finite.size else 0.0

    return Reach(
        peak([c.x for c in courses]),
        peak([c.v for c in courses]),
        max(float(c.u.max()) for c in courses),
        "the data",
    )


def _seconds(mask: Mask, dt: float) -> float:
    """Time in a region [s]."""
    return float(np.count_nonzero(mask)) * dt


def _steps(c: Course, r: Reach, sign: float) -> float:
    """Steps of the duty, up or down, while the damper moves."""
    if r.duty <= 0.0:
        return 0.0
    moving = np.abs(c.v[1:]) > 0.05 * r.velocity
    return float(np.count_nonzero((sign * np.diff(c.u) > STEP * r.duty) & moving))


def _levels(courses: Sequence[Course], r: Reach) -> float:
    """Number of tenths of the duty's reach in which it stays for half a second or more, over all records."""
    if r.duty <= 0.0:
        return 1.0
    seconds = np.zeros(LEVELS)
    for c in courses:
        known = c.u[np.isfinite(c.u)]
        place = np.clip((known / r.duty * LEVELS).astype(int), 0, LEVELS - 1)
        seconds += np.bincount(place, minlength=LEVELS) * c.dt
    return float(np.count_nonzero(seconds >= 0.5))


def _reversals(c: Course, r: Reach) -> float:
    """Reversals of the motion, those within the noise aside."""
    side = np.where(np.abs(c.v) > 0.1 * r.velocity, np.sign(c.v), 0.0)
    side = side[side != 0.0]
    return float(np.count_nonzero(np.diff(side)))


def _load_change(c: Course, _: Reach) -> float:
    """Largest over smallest mean dissipated power of four parts of a record."""
    power = np.abs(c.force * c.v)
    parts = [float(p.mean()) for p in np.array_split(power, 4)]
    return max(parts) / max(min(parts), 1e-300) if np.isfinite(parts).all() else 1.0


def _warming(courses: Sequence[Course]) -> float:
    """Range of the temperature over all records that have one [K]."""
    theta = np.concatenate([c.theta for c in courses])
    theta = theta[np.isfinite(theta)]
    return float(np.ptp(theta)) if theta.size else 0.0


def _high(c: Course, r: Reach) -> Mask:
    """Where the duty is high."""
    return np.asarray((c.u > 0.6 * r.duty) & (r.duty > 0.0))


CELLS: dict[str, Cell] = {
    c.name: c
    for c in (
        Cell("slow", "velocity below 15 % of the reach, at least 1 % of it", 2.0, "s",
             lambda c, r: _seconds((np.abs(c.v) < 0.15 * r.velocity) & (np.abs(c.v) > 0.01 * r.velocity), c.dt)),
        Cell("fast_extension", "extension faster than 60 % of the reach", 0.5, "s",
             lambda c, r: _seconds(c.v > 0.6 * r.velocity, c.dt)),
        Cell("fast_compression", "compression faster than 60 % of the reach", 0.5, "s",
             lambda c, r: _seconds(c.v < -0.6 * r.velocity, c.dt)),
        Cell("far_extension", "deflection beyond 70 % of the reach, extended", 0.3, "s",
             lambda c, r: _seconds(c.x > 0.7 * r.deflection, c.dt)),
        Cell("far_compression", "deflection beyond 70 % of the reach, compressed", 0.3, "s",
             lambda c, r: _seconds(c.x < -0.7 * r.deflection, c.dt)),
        Cell("reversals", "reversals of the motion", 20.0, "times", _reversals),
        Cell("low_duty", "duty below 5 % of the reach", 2.0, "s",
             lambda c, r: _seconds(c.u <= 0.05 * r.duty, c.dt)),
        Cell("small_duty", "duty between 1 % and 20 % of the reach", 1.0, "s",
             lambda c, r: _seconds((c.u > 0.01 * r.duty) & (c.u < 0.2 * r.duty), c.dt)),
        Cell("high_duty", "duty above 60 % of the reach", 2.0, "s",
             lambda c, r: _seconds(_high(c, r), c.dt)),
        Cell("duty_levels", "different duties held", FEW_LEVELS, "duties",
             lambda c, r: _levels([c], r)),
        Cell("duty_rises", "steps of the duty up, in motion", 5.0, "times", lambda c, r: _steps(c, r, 1.0)),
        Cell("duty_falls", "steps of the duty down, in motion", 5.0, "times", lambda c, r: _steps(c, r, -1.0)),
        Cell("fast_high_duty", "velocity above 60 % and duty above 60 % of the reach", 0.5, "s",
             lambda c, r: _seconds((np.abs(c.v) > 0.6 * r.velocity) & _high(c, r), c.dt)),
        Cell("far_high_duty", "deflection beyond 60 % and duty above 60 % of the reach", 0.3, "s",
             lambda c, r: _seconds((np.abs(c.x) > 0.6 * r.deflection) & _high(c, r), c.dt)),
        Cell("minutes", "length of one record", 60.0, "s", lambda c, _: c.x.size * c.dt),
        Cell("load_change", "most over least dissipated power within a record", 2.0, "times", _load_change),
        Cell("warming", "range of the temperature", 5.0, "K", lambda c, _: _warming([c])),
    )
}  # fmt: skip
"""Every region of `er_models.effect.REGIONS`, by name."""

LARGEST = ("minutes", "load_change")
"""Counts that do not add up over records: the best record counts."""


def needs(effect: Effect) -> tuple[str, ...]:
    """Regions without which an effect cannot be seen: as it says, else by the signals its equation uses."""
    if effect.signature.needs is not None:
        return effect.signature.needs
    used = {a for hook in effect.hooks.values() for a in inspect.signature(hook).parameters}
    found: list[str] = []
    if "v" in used:
        found += ["fast_extension", "fast_compression"]
    if "x" in used:
        found += ["far_extension", "far_compression"]
    if used & {"u", "u_f"}:
        found += ["duty_levels"]
        found += ["fast_high_duty"] if "v" in used else []
        found += ["far_high_duty"] if "x" in used else []
    if effect.stage == "heat" or "t" in used:
        found += ["minutes"]
    if "theta" in used:
        found += ["warming"]
    return tuple(found)


def counts(courses: Sequence[Course], reach: Reach) -> dict[str, float]:
    """How much there is of each region, over all records."""
    out = {}
    for name, cell in CELLS.items():
        each = [cell.count(c, reach) for c in courses]
        out[name] = max(each) if name in LARGEST else float(sum(each))
    out["duty_levels"] = _levels(courses, reach)
    out["warming"] = _warming(courses)
    return out


def missing(catalogue: Catalogue, have: dict[str, float]) -> dict[str, tuple[str, ...]]:
    """Effect to the regions it lacks; effects that lack nothing are left out."""
    lacking = {name for name, cell in CELLS.items() if have[name] < cell.need}
    found = {
        e.name: tuple(n for n in needs(e) if n in lacking)
        for e in catalogue.effects
        if e.knowable and e.stage in ("force", "actuation", "heat", "sensing")
    }
    return {name: cells for name, cells in found.items() if cells}
