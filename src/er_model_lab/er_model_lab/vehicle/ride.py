r"""The car as a forward model: what its sensors show, from road and duty, with the states at the start free.

A record is cut into blocks of some ten seconds. Every block starts from a mechanical state of its own, so that
errors do not add up; the states of the damper go on. For any model these starts are those that fit the first
half second of a block best,

.. math:: \delta = \arg\min_\delta \| e_0 - S_0 \delta \|, \quad e \leftarrow e - S \delta

with the sensitivity S of the outputs to the start, taken once with a fitted model: from there the corrections are
as small as the noise. That half second is not scored.
"""

from __future__ import annotations

import itertools
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from er_models.errors import InputError
from er_models.model import Array, Model
from er_models.parallel import over_cores
from er_models.simulation import State, history, initial_state, prepare
from scipy.interpolate import CubicSpline

BLOCK = 10.0
"""Length of a block [s]."""
SETTLE = 0.5
"""Part of a block from which its start is estimated [s]; not scored."""
STEP = 0.625e-3
"""Longest step of the integrator [s]; the road is followed at every step."""
EXACT = 1e-2
"""Tolerance of the integrator over its usual one, so that small steps of a parameter show."""
CHANNELS = {
    "damper_force": 3, "sprung_acceleration": 0, "unsprung_acceleration": 1, "deflection": 4,
    "deflection_velocity": 5, "sprung_displacement": 6, "unsprung_displacement": 7,
}  # fmt: skip
"""Outputs of the car that may be measured, and where `drive` has them."""
OUTPUTS = 8
"""How many `drive` gives: those of `er_models.simulation.history`, and both displacements."""


@dataclass(frozen=True)
class Course:
    """Inputs of one record: road at each step (m (n - 1) + 1,), its rate and duty (n,), first rows of blocks, end.

    beside (n,): force of an actuator beside the damper [N].
    """

    road: Array
    rates: Array
    duty: Array
    edges: tuple[int, ...]
    beside: Array


def course(dt: float, road: Array, duty: Array, beside: Array, *, smooth: bool) -> Course:
    """Inputs of a record; between samples the road is a cubic spline, or straight lines."""
    n, m = road.size, steps(dt)
    at, fine = np.arange(n) * dt, np.arange(m * (n - 1) + 1) * (dt / m)
    if smooth:
        curve = CubicSpline(at, road)
        height, rates = curve(fine), curve(at, 1)
    else:
        height, rates = np.interp(fine, at, road), np.append(np.diff(road) / dt, 0.0)
    count = max(1, round(n * dt / BLOCK))
    return Course(
        np.asarray(height),
        np.asarray(rates),
        duty,
        tuple(int(e) for e in np.linspace(0, n, count + 1)),
        beside,
    )


def steps(dt: float) -> int:
    """Steps of the integrator in a sample."""
    return max(1, int(np.ceil(dt / STEP - 1e-9)))


def drive(model: Model, dt: float, path: Course, starts: Array | None) -> tuple[Array, Array]:
    """Mechanical states (n, 4) and outputs (n, 8) along a record.

    starts (blocks, 4): mechanical state at the start of each block; None: at rest, and no cuts.
    """
    m = steps(dt)
    plant = prepare(model, dt)
    plant = replace(plant, n_sub=m, tolerance=EXACT * plant.tolerance)
    edges = path.edges if starts is not None else (0, path.edges[-1])
    states, outputs = np.empty((edges[-1], 4)), np.empty((edges[-1], OUTPUTS))
    state: State | None = None
    for b, (i, j) in enumerate(itertools.pairwise(edges)):
        q = starts[b] if starts is not None else np.zeros(4)
        if state is None:
            state = initial_state(plant, float(path.road[0]), float(path.duty[0]), q)
        state = state._replace(q=np.array(q, float))
        last = min(j, edges[-1] - 1)
        road, at = path.road[i * m : last * m + 1], slice(i, last + 1)
        state, found, seen = history(
            plant, state, road, path.duty[at], path.rates[at], path.beside[at]
        )
        states[i:j], outputs[i:j, :6] = found[: j - i], seen[: j - i]
    outputs[:, 7] = states[:, 2] + path.road[::m]
    with np.errstate(invalid="ignore"):  # a car that has fallen over
        outputs[:, 6] = states[:, 0] + outputs[:, 7]
    return states, outputs


def with_values(model: Model, vector: Array) -> Model:
    """The model with the values of a flat parameter vector (n_parameters,)."""
    effects = {
        name: dict(zip(model.catalogue[name].names, vector[at:].tolist(), strict=False))
        for name in model.effects
        for at in (model.catalogue.offsets[name],)
    }
    return replace(model, effects=effects)


def drive_many(jobs: list[tuple[Model, Array]], dt: float, paths: tuple[Course, ...]) -> Array:
    """Outputs (m, n, 8) along all records of models with their starts (blocks, 4), over all cores.

    NaN for what cannot be simulated.
    """
    rows = np.cumsum([0, *(p.edges[-1] for p in paths)])
    blocks = np.cumsum([0, *(len(p.edges) - 1 for p in paths)])
    out = np.full((len(jobs), int(rows[-1]), OUTPUTS), np.nan)

    def run(i: int, j: int) -> None:
        for k in range(i, j):
            model, starts = jobs[k]
            for r, path in enumerate(paths):
                q = starts[blocks[r] : blocks[r + 1]]
                with suppress(InputError):
                    out[k, rows[r] : rows[r + 1]] = drive(model, dt, path, q)[1]

    over_cores(run, len(jobs), len(jobs) * int(rows[-1]) * steps(dt))
    return out
