"""Data made by the lab's own equations, so that every fitted parameter has a true value.

The truth is the quarter car with the damper up to 12 % off and one effect, on the generator's roads, from
rest, with the generator's noise. Values are a starting point of the effect, each up to a factor 1.4 away; the
parameters that switch the effect on are then moved together until a refitted healthy base leaves a drawn
10 to 400 % more than the force noise.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from er_models.catalogue import CATALOGUE
from er_models.effect import Effect
from er_models.errors import InputError
from er_models.files import load_model
from er_models.model import Model
from er_models.simulation import simulate

from test.blind.calibrate import LEAST_RISE, MOST_RISE, solve
from test.blind.effect import between
from test.blind.integrate import LEAD_SAMPLES, SAMPLE, SUBSTEPS
from test.blind.measure import COLUMNS, Noise, with_noise
from test.blind.plant import SPREAD, draw_base, draw_motions
from test.blind.refit import excess, left_for, refit
from test.blind_score.rows import ROOT

VEHICLE = ROOT / "config" / "vehicles" / "inove_quarter_car.yaml"
DRAWS = 12
MOST_FACTOR = 3.0
FINER = 8
"""Steps of the simulation in a sample: the road is a straight line within a step, and each bend is a jerk."""
_SPAN = 1.4
_FASTEST, _LONGEST = 0.2, 0.02
_DIVERGED = 1e3
"""Residual [N] that stands for a simulation that did not stay finite."""
Channels = dict[str, np.ndarray]


@dataclass(frozen=True)
class LabTruth:
    """The true model, and its rise over the noise once a healthy base is refitted."""

    model: Model
    rise: float
    records: list[Channels]


def base_model(rng: np.random.Generator) -> Model:
    """The quarter car with every damper value up to 12 % off."""
    model = load_model(VEHICLE)
    effects = {name: dict(values) for name, values in model.effects.items()}
    for name, values in effects.items():
        if name != "quarter_car":
            for q in values:
                values[q] *= 1.0 + rng.uniform(-SPREAD, SPREAD)
    return Model(model.name, effects, model.scales, rig=model.rig)


def switched(effect: Effect) -> list[str]:
    """Parameters whose neutral value switches the effect off."""
    return [q.name for q in effect.parameters if q.neutral is not None]


def shape(effect: Effect, model: Model, rng: np.random.Generator) -> dict[str, float]:
    """A starting point of the effect [SI], each fitted value up to a factor away."""
    points = list(itertools.product(*(q.starts for q in effect.parameters)))
    point = points[int(rng.integers(len(points)))]
    out = {}
    for q, start in zip(effect.parameters, point, strict=True):
        factor = between(rng, 1.0 / _SPAN, _SPAN) if q.fitted else 1.0
        scale = model.scales.of(q.unit)
        out[q.name] = float(np.clip(start * factor, q.low, q.high)) * scale
    return out


def moved(effect: Effect, point: dict[str, float], size: float, model: Model) -> dict[str, float]:
    """The point with its switches at ``size`` times their distance from neutral, within bounds."""
    out = dict(point)
    for name in switched(effect):
        q = effect.parameter(name)
        scale = model.scales.of(q.unit)
        if np.isinf(q.neutral or 0.0):
            value = point[name] / size
        else:
            neutral = (q.neutral or 0.0) * scale
            value = neutral + size * (point[name] - neutral)
        out[name] = float(np.clip(value, q.low * scale, q.high * scale))
    return out


def inside(effect: Effect, values: dict[str, float], model: Model) -> bool:
    """Whether every fitted value is one to ask an interval for.

    None is at a bound, and a factor or power whose neutral value is one is at most threefold or a third.
    """
    for q in effect.parameters:
        low, high = model.bounds(effect.name, q.name)
        value = values[q.name]
        if q.fitted and not low + 1e-9 * abs(low) < value < high - 1e-9 * abs(high):
            return False
        if q.neutral == 1.0 and not 1.0 / MOST_FACTOR <= value <= MOST_FACTOR:
            return False
    return True


def draw_truth(name: str, seed: int, records: int, seconds: float) -> LabTruth:
    """The truth of a seed with its noiseless records.

    Raises:
        InputError: no draw shows by 10 to 600 % with every value inside its bounds.
    """
    effect, rng = CATALOGUE[name], np.random.default_rng([seed, len(name), *name.encode()])
    model, noise = base_model(rng), Noise().force
    motions = draw_motions(
        "car", "rich", records, seconds, draw_base(rng), np.random.SeedSequence([seed, records])
    )
    n = round(seconds / SAMPLE) * FINER
    inputs = [
        (
            m.drive[:: 2 * SUBSTEPS // FINER, 0][:n],
            np.repeat(m.duty[LEAD_SAMPLES:], FINER)[:n],
        )
        for m in motions
    ]

    def made(values: dict[str, float]) -> list[Channels]:
        full = model.with_effect(name, values)
        fine = [simulate(full, SAMPLE / FINER, road, duty) for road, duty in inputs]
        return [{k: y[::FINER] for k, y in record.items()} for record in fine]

    for _ in range(DRAWS):
        point, goal = shape(effect, model, rng), between(rng, 0.15, 4.0)

        def left(size: float, point: dict[str, float] = point) -> float:
            found = made(moved(effect, point, size, model))
            finite = all(np.isfinite(r["damper_force"]).all() for r in found)
            return refit(found, offset=name != "preload").rms if finite else _DIVERGED

        size, rms = solve(left, 1.0, left_for(goal, noise), (0.02, 30.0))
        values, rise = moved(effect, point, size, model), excess(rms, noise)
        found = made(values)
        if LEAST_RISE <= rise <= MOST_RISE and inside(effect, values, model) and sane(found):
            return LabTruth(model.with_effect(name, values), rise, found)
    raise InputError(name, "strength", "a rise of 10 to 600 % inside the bounds", f"{rise:.1%}")


def sane(records: list[Channels]) -> bool:
    """Whether the car stays within what a rig of this size can do."""
    fast = max(float(np.abs(r["deflection_velocity"]).max()) for r in records)
    long = max(float(np.abs(r["deflection"]).max()) for r in records)
    return fast < _FASTEST and long < _LONGEST


def write_noisy(truth: LabTruth, seed: int, folder: Path) -> Path:
    """The records with noise as CSV files of a folder."""
    folder.mkdir(parents=True)
    for i, record in enumerate(truth.records):
        noisy = with_noise(record, Noise(), np.random.default_rng([seed, i, 1]))
        columns = np.stack([noisy[name] for name in COLUMNS], axis=1)
        np.savetxt(
            folder / f"record_{i + 1}.csv",
            columns,
            "%.9g",
            ",",
            header=",".join(COLUMNS),
            comments="",
        )
    return folder
