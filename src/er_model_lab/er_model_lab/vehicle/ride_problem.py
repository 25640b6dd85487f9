"""From records to a fitting problem at the level of the vehicle."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from er_models.errors import InputError, MissingChannel
from er_models.model import Array, Model
from er_models.prediction import Motion
from er_models.scales import Scales, peak
from er_records.dataset import Dataset
from er_records.missing_channels import NO_DUTY
from er_records.record import Record
from numpy.typing import NDArray

from er_model_lab.fitting.fit import Fit, fit
from er_model_lab.motion.fuse import Noise
from er_model_lab.motion.white_noise import white_noise
from er_model_lab.problem.held_out import FOLDS, TO_FIT, TO_HOLD_OUT, split
from er_model_lab.problem.prepare import resampled, without_weight
from er_model_lab.problem.problem import Problem
from er_model_lab.vehicle.ride import CHANNELS, SETTLE, Course, course, drive
from er_model_lab.vehicle.ride_forward import CAR, RideForward, with_starts
from er_model_lab.work import HERE, Work

ROADS = {
    "the road between samples is taken as smooth": True,
    "the road between samples is taken as straight: that leaves less than a smooth one": False,
}
ACTUATOR = "actuator_force"
"""Input that a car may have beside road and duty."""
SHORTEST_RIDE = 3.0
"""Shortest ride of all records together [s]: what a model leaves is moved along it by a second and more."""
LEAST_NOISE = 1e-3
"""Noise that an output is taken to have at least, as a share of its size: no simulation is nearer to a car."""


@dataclass(frozen=True)
class Measured:
    """Records of a car on a common grid: per record road, duty and force beside the damper (n,), all outputs (n, c)."""

    dt: float
    names: tuple[str, ...]
    roads: tuple[Array, ...]
    duties: tuple[Array, ...]
    beside: tuple[Array, ...]
    outputs: Array


def open_ride(given: Dataset, model: Model, work: Work = HERE) -> tuple[Problem, Fit]:
    """The problem that records of a car pose to a vehicle model, and the model fitted to it.

    The noise of every output is read off what a first fit leaves; so is whether the road between two samples is
    smooth (a street, a rig) or straight (a simulation that joins them).

    Raises:
        MissingChannel: Without road or duty, or without any output.
        InputError: When the model has no quarter car, or there is not enough data.
    """
    data = _opened(given.records, model)
    size = _noise(data, data.outputs)
    first = _weighted(_ride(data, model), data, model, size)
    problem = _problem(given, data, with_starts(first, model, check=work.check), model)
    problem = replace(problem, work=work)
    fitted = fit(model, problem)
    left = fitted.residual.reshape(-1, len(data.names)) / first.weights
    again = _weighted(first, data, model, _noise(data, left))
    found = [
        (problem, fit(fitted.model, problem))
        for problem in _on_roads(given, data, again, fitted.model, work)
    ]
    problem, fitted = min(found, key=lambda pf: pf[1].mse(pf[0].train))
    return replace(problem, notes=(*_another_car(fitted, model), *problem.notes)), fitted


def _another_car(fitted: Fit, given: Model) -> Iterator[str]:
    """That a value of the car ends as far from the given one as it may: the model may be that of another car."""
    for (effect, name), at_bound in zip(fitted.free, fitted.at_bound, strict=True):
        if at_bound and effect == "quarter_car" and name in CAR:
            before, after = (m.value(effect, name) for m in (given, fitted.model))
            far = "half" if after < before else "twice"
            unit = given.catalogue[effect].parameter(name).unit
            yield (
                f"{name} ends at {after:.4g} {unit}, {far} what the model gives and as far as it may go: begin with "
                "values that were measured on this car"
            )


def ride_as_given(given: Dataset, model: Model) -> tuple[Problem, Array]:
    """The same problem for a model as it is, and its residual (n,): nothing but the starts of the blocks is fitted.

    Raises as `open_ride`.
    """
    data = _opened(given.records, model)
    forward = _weighted(_ride(data, model), data, model, _noise(data, data.outputs))
    found = [
        (problem, problem.force - problem.predict(model))
        for problem in _on_roads(given, data, forward, model)
    ]
    return min(found, key=lambda pr: float(np.mean(pr[1][pr[0].used] ** 2)))


def _opened(records: Sequence[Record], model: Model) -> Measured:
    """Inputs and outputs of a car for a model that has one."""
    if not model.is_vehicle:
        expected = "a vehicle model with quarter_car"
        raise InputError(model.name, "quarter_car", expected, "a damper only")
    return measured(records)


def _on_roads(
    given: Dataset, data: Measured, forward: RideForward, model: Model, work: Work = HERE
) -> Iterator[Problem]:
    """The problem with each way in which the road may run between two samples."""
    for road, smooth in ROADS.items():
        on_road = replace(forward, courses=_courses(data, smooth=smooth))
        moved = with_starts(on_road, model, check=work.check)
        problem = _problem(given, data, moved, model)
        said = (*problem.notes, road, _measure(data), *_not_used(given, data))
        yield replace(problem, notes=said, work=work)


def _not_used(given: Dataset, data: Measured) -> Iterator[str]:
    """What is there and not used: of long data what was not searched, and channels that some records lack."""
    whole = given.originals
    if given.whole is not None:
        seconds = sum(float(r.t[-1] - r.t[0]) + r.dt for r in whole)
        searched = sum(road.size for road in data.roads) * data.dt
        yield (
            f"{searched:.0f} of {seconds:.0f} s searched, in {len(given.records)} stretches that cover what the data "
            "hold; "
            "what they give was not checked on the rest"
        )
    for c in CHANNELS:
        having = sum(r.has(c) and c not in r.derived for r in whole)
        if c not in data.names and having:
            yield f"{c} is not used: {len(whole) - having} of {len(whole)} records lack it"
    for c in ("duty", ACTUATOR):
        driven = sum(r.has(c) for r in whole)
        if 0 < driven < len(whole):
            yield f"{c} counts as 0 in {len(whole) - driven} of {len(whole)} records, which lack it"
    if not any(r.has("duty") for r in whole):
        yield NO_DUTY


def _measure(data: Measured) -> str:
    """What a newton of an effect's size is."""
    return f"sizes of effects are of all outputs together, each weighted by its noise to that of {data.names[0]}"


def measured(records: Sequence[Record]) -> Measured:
    """Inputs and outputs of a car; outputs that not all records have are left out."""
    if not records:
        raise InputError("data", "", "at least one record", "none")
    dt, why = max(r.dt for r in records), "to simulate the car"
    for r in records:
        r.need("road", why)
    names = tuple(c for c in CHANNELS if all(r.has(c) and c not in r.derived for r in records))
    if not names:
        r, (first, *others) = records[0], CHANNELS
        needed = f"(or {', '.join(others)}, one that all records have) to hold the simulated car against"
        raise MissingChannel(r.source or r.name, first, needed, tuple(r.channels), r.cure)
    outputs = [np.stack([resampled(r, c, dt) for c in names], axis=1) for r in records]
    return Measured(
        dt, names, tuple(resampled(r, "road", dt) for r in records),
        tuple(_or_none(r, "duty", dt) for r in records), tuple(_or_none(r, ACTUATOR, dt) for r in records),
        np.concatenate(outputs),
    )  # fmt: skip


def _or_none(record: Record, channel: str, dt: float) -> Array:
    """An input of the car (n,), the duty or the force [N] of an actuator beside the damper; 0 where not recorded."""
    if record.has(channel):
        return resampled(record, channel, dt)
    return np.zeros(resampled(record, "road", dt).size)


def _courses(data: Measured, *, smooth: bool) -> tuple[Course, ...]:
    """Inputs of all records."""
    each = zip(data.roads, data.duties, data.beside, strict=True)
    return tuple(course(data.dt, *inputs, smooth=smooth) for inputs in each)


def _ride(data: Measured, model: Model) -> RideForward:
    """The forward model before anything is fitted: starts as the model and the sensors have them."""
    courses = _courses(data, smooth=True)
    runs = [drive(model, data.dt, path, None) for path in courses]
    states = np.concatenate([s for s, _ in runs])
    c, offset, starts = len(data.names), 0, []
    for path, (q, _) in zip(courses, runs, strict=True):
        at = q[list(path.edges[:-1])]
        at[0] = _standing(data, path, offset)
        starts.append(at)
        offset += path.edges[-1]
    seen = np.concatenate([o for _, o in runs])
    return RideForward(
        data.dt, courses, data.names, np.ones(c), np.ones(c), data.outputs.ravel(), _envelope(data, seen),
        model.effects["quarter_car"],
        np.maximum(states.std(axis=0), 1e-9), np.concatenate(starts),
    )  # fmt: skip


def _standing(data: Measured, path: Course, row: int) -> Array:
    """Start of a record (4,): the wheel follows the road, the body the sensors."""
    m = (path.road.size - 1) // (path.edges[-1] - 1)
    wheel = float(path.road[m] - path.road[0]) / data.dt
    known = dict(zip(data.names, data.outputs[row], strict=True))
    v = known.get("deflection_velocity", 0.0)
    return np.array([known.get("deflection", 0.0), v + wheel, 0.0, wheel])


def _envelope(data: Measured, seen: Array) -> Scales:
    """Robust peaks of force, deflection, velocity and duty: as measured, else as simulated."""
    peaks = {}
    for name in ("damper_force", "deflection", "deflection_velocity"):
        known = name in data.names
        y = data.outputs[:, data.names.index(name)] if known else seen[:, CHANNELS[name]]
        peaks[name] = peak(y)
    duty = max(float(u.max()) for u in data.duties)
    return Scales(
        peaks["damper_force"], peaks["deflection"], peaks["deflection_velocity"], max(duty, 1e-3)
    )


def _noise(data: Measured, left: Array) -> Array:
    """White noise (c,) of each output in its unit [N, m, m/s, m/s2], from what is left of it (n, c)."""
    ends = np.cumsum([road.size for road in data.roads])[:-1]
    white = [white_noise(np.split(column, ends)) for column in left.T]
    return np.asarray(np.maximum(white, LEAST_NOISE * data.outputs.std(axis=0) + 1e-12))


def _weighted(forward: RideForward, data: Measured, model: Model, noise: Array) -> RideForward:
    """Outputs whose noise (c,) becomes that of the first, in newtons."""
    car, s = model.effects["quarter_car"], forward.envelope
    newtons = {
        "damper_force": 1.0, "sprung_acceleration": car["m_s"], "unsprung_acceleration": car["m_us"],
        "deflection": car["k_s"], "deflection_velocity": s.force / s.velocity, "sprung_displacement": car["k_s"],
        "unsprung_displacement": car["k_t"],
    }  # fmt: skip
    weights = newtons[data.names[0]] * noise[0] / noise
    return replace(
        forward, weights=weights, noise=noise, measured=(data.outputs * weights).ravel()
    )


def _check_rides(fold: NDArray[np.int64], held_out: NDArray[np.bool_], data: Measured) -> None:
    """Refuse rides of which too little is left where every block has settled."""
    fit, score = int(np.sum(fold >= 0)), int(held_out.sum())
    seconds = fold.size * data.dt
    if fit < TO_FIT or score < TO_HOLD_OUT or seconds < SHORTEST_RIDE:
        expected = f"{SHORTEST_RIDE:g} s at least, with {TO_FIT} samples to fit and {TO_HOLD_OUT} to hold out"
        raise InputError("data", "length", expected, f"{fit} and {score} in {seconds:.3g} s")


def _problem(given: Dataset, data: Measured, forward: RideForward, model: Model) -> Problem:
    """Rows and who may see them; nothing of a block's first part is scored."""
    states, seen = forward.ride(model)
    rows = np.cumsum([0, *(road.size for road in data.roads)])
    motion = Motion(
        data.dt, states[:, 0], states[:, 1] - states[:, 3], seen[:, 0] - seen[:, 1],
        np.concatenate(data.duties), np.zeros(rows[-1]), rows,
    )  # fmt: skip
    records = given.records
    fold, held_out = split(motion, len(given.score), evenly=True)
    for i, j in forward.blocks():
        first = slice(i, min(i + round(SETTLE / data.dt), j))
        fold[first], held_out[first] = -1, False
    wild = np.concatenate([without_weight(r, data.dt) for r in records])
    fold[wild], held_out[wild] = -1, False
    order = np.flatnonzero(fold >= 0)
    if np.unique(fold[order]).size < FOLDS:
        fold[order] = np.arange(order.size) * FOLDS // max(order.size, 1)
    _check_rides(fold, held_out, data)
    c = forward.outputs
    slope = np.concatenate([np.gradient(road, data.dt) for road in data.roads])
    return Problem(
        motion=motion, force=forward.measured, fold=np.repeat(fold, c), held_out=np.repeat(held_out, c), raw=(),
        fused=(), noise=Noise(0.0, 0.0, 0.0, 0.0), names=tuple(r.name for r in records),
        notes=tuple(dict.fromkeys(n for r in records for n in r.notes)), complete=all(r.complete for r in records),
        sd_force=float(forward.weights[0] * forward.noise[0]), velocity_lag=(0.0, float("inf")), forward=forward,
        extra=(("tyre deflection", states[:, 2]), ("tyre velocity", states[:, 3] - slope)),
        wild=np.repeat(wild, c),
    )  # fmt: skip
