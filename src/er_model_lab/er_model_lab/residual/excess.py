"""Where a model fails: the error beyond the noise, against each quantity that may be its cause.

In every region the mean square of the noise is taken off that of the residual; the root of the rest is what the
model does there. Noise is not the same everywhere: errors of the motion sensors weigh most where the gate
closes. Bands are of a block bootstrap (Kuensch 1989): blocks of a second are drawn again, so that errors which
last do not count as many.
"""

from __future__ import annotations

import itertools

import numpy as np
from er_models.model import Array
from numpy.typing import NDArray

from er_model_lab.filtering import fading
from er_model_lab.problem.problem import Problem
from er_model_lab.residual.region import Region, RegionTable

QUANTILES = (0.0, 0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.98, 1.0)
"""Edges of the bins: fine at both ends, where stops and cut-offs show."""
BANDS = (0.0, 1.0, 2.0, 5.0, 10.0, 20.0, 40.0, np.inf)
"""Edges of the bands of frequency [Hz]."""
SEGMENT = 2.0
"""Length of a segment of a spectrum [s]."""
LEVELS = 6
"""A quantity with so few values gets a bin for each."""
BOOTSTRAPS = 200


def noise_at(problem: Problem, floor: float, input_square: Array) -> Array:
    """Mean square of the noise (n,) [N2] at each sample of the first output, of which `floor` [N] is the root mean.

    input_square (n * outputs,): what the errors of the input sensors cause [N2]; the rest is the same everywhere.
    """
    n, train = problem.forward.outputs, problem.parts[0].train
    moved = input_square[::n]
    mean = float(moved[train].mean()) if train.any() else float(moved.mean())
    share = min(1.0, floor**2 / mean) if mean > 0.0 else 0.0
    return np.asarray(share * moved + floor**2 - share * mean)


def region_tables(
    problem: Problem, residual: Array, seed: int, noise: Array | None = None
) -> tuple[RegionTable, ...]:
    """Error against deflection, velocity, acceleration, duty, duty rate, time, work done, direction, frequency.

    residual (n * outputs,) [N], of which the first output is looked at; noise (n,): mean square of the noise [N2] at
    each sample, by default none.
    """
    n, problem = problem.forward.outputs, problem.parts[0]
    residual = residual[::n]
    noise = np.zeros(residual.size) if noise is None else noise
    rng = np.random.default_rng(seed)
    tables = [
        _table(problem, residual, noise, name, unit, y, rng)
        for name, unit, y in quantities(problem, problem.force - residual)
    ]
    tables.append(_frequency_table(problem, residual, noise, rng))
    return tuple(t for t in tables if len(t.regions) > 1)


def quantities(problem: Problem, force: Array) -> list[tuple[str, str, Array]]:
    """Name, unit and values (n,) of what the error may depend on; force (n,): what the model predicts [N]."""
    m = problem.motion
    rate = np.concatenate([[0.0], np.diff(m.u)]) / m.dt
    recent = fading(np.abs(rate) * m.dt, np.exp(-m.dt / 0.05))
    work = np.concatenate(
        [np.cumsum(np.abs(force[i:j] * m.v[i:j])) * m.dt for i, j in _pairs(problem)]
    )
    time = np.concatenate([np.arange(j - i) * m.dt for i, j in _pairs(problem)])
    found: list[tuple[str, str, Array]] = [
        ("deflection", "m", m.x), ("velocity", "m/s", m.v), ("acceleration", "m/s2", m.a), ("duty", "1", m.u),
        ("duty change in the last 50 ms", "1", np.where(recent < 1e-3, 0.0, recent)),
        ("time", "s", time), ("work done", "J", work), ("direction", "1", np.sign(m.v)),
    ]  # fmt: skip
    if np.ptp(m.theta) > 0.5:
        found.append(("temperature", "K", m.theta))
    return found


def _pairs(problem: Problem) -> list[tuple[int, int]]:
    """First and last row of each record."""
    return [(int(i), int(j)) for i, j in itertools.pairwise(problem.motion.starts)]


def _edges(values: Array) -> tuple[Array, NDArray[np.intp]]:
    """Edges of the bins of a quantity, and the bin of each value; few values get a bin each."""
    levels = np.unique(np.round(values, 12))
    if levels.size <= LEVELS:
        return np.concatenate([levels, [levels[-1]]]), np.searchsorted(
            levels, np.round(values, 12)
        )
    edges = np.unique(np.quantile(values, QUANTILES))
    return edges, np.clip(np.searchsorted(edges, values, side="right") - 1, 0, edges.size - 2)


def _table(
    problem: Problem, residual: Array, noise: Array, name: str, unit: str, y: Array, rng: np.random.Generator
) -> RegionTable:  # fmt: skip
    """Error and noise over bins of a quantity."""
    rows = np.flatnonzero(problem.used)
    values, squared, quiet = y[rows], residual[rows] ** 2, noise[rows]
    edges, place = _edges(values)
    blocks = rows // max(round(1.0 / problem.motion.dt), 1)
    regions, total = [], max(float(squared.sum()), 1e-300)
    for b in range(int(place.max(initial=-1)) + 1):
        inside = place == b
        if not inside.any():
            continue
        ends = (float(edges[b]), float(edges[min(b + 1, edges.size - 1)]))
        share = float(squared[inside].sum() / total)
        band = _band(*_blocked(squared[inside], blocks[inside]), rng)
        square, floor = float(squared[inside].mean()), float(quiet[inside].mean())
        regions.append(_region(name, unit, ends, share, float(inside.mean()), square, floor, band))
    return RegionTable(name, unit, tuple(regions))


def _region(
    name: str, unit: str, ends: tuple[float, float], share: float, of_samples: float, square: float, floor: float,
    band: tuple[float, float],
) -> Region:  # fmt: skip
    """A region from its mean square error, that of the noise, and the band of the former [N2]."""

    def beyond(value: float) -> float:
        return float(np.sqrt(max(value - floor, 0.0)))

    low, high = band
    return Region(
        name, unit, ends, share, of_samples, float(np.sqrt(square)), (float(np.sqrt(low)), float(np.sqrt(high))),
        float(np.sqrt(floor)), beyond(square), (beyond(low), beyond(high)),
    )  # fmt: skip


def _blocked(squared: Array, blocks: NDArray[np.int64]) -> tuple[Array, Array]:
    """Sum and number of the squares in each block."""
    _, place = np.unique(blocks, return_inverse=True)
    return np.asarray(np.bincount(place, squared), np.float64), np.bincount(place).astype(
        np.float64
    )


def _band(sums: Array, counts: Array, rng: np.random.Generator) -> tuple[float, float]:
    """90 % interval of a mean square over blocks drawn again."""
    picks = rng.integers(0, sums.size, (BOOTSTRAPS, sums.size))
    means = sums[picks].sum(axis=1) / counts[picks].sum(axis=1)
    low, high = np.quantile(means, [0.05, 0.95])
    return float(low), float(high)


def _powers(problem: Problem, residual: Array) -> tuple[Array, Array]:
    """Frequencies (f,) [Hz] and mean square (segments, f) [N2] of the residual in segments that overlap by half."""
    dt = problem.motion.dt
    length = max(round(SEGMENT / dt), 16)
    length = min(length, *(j - i for i, j in _pairs(problem)))
    window = np.hanning(length)
    out = []
    for i, j in _pairs(problem):
        for k in range(i, j - length + 1, max(length // 2, 1)):
            e = residual[k : k + length]
            power = np.abs(np.fft.rfft((e - e.mean()) * window)) ** 2
            power[1 : (length + 1) // 2] *= 2.0
            out.append(power / (length * float(np.sum(window**2))))
    return np.asarray(np.fft.rfftfreq(length, dt), np.float64), np.asarray(out)


def _frequency_table(
    problem: Problem, residual: Array, noise: Array, rng: np.random.Generator
) -> RegionTable:
    """Error in bands of frequency; the noise is taken as white.

    The share of the data is that which a model would have that errs by the same part of the force everywhere.
    """
    f, power = _powers(problem, residual)
    force = _powers(problem, problem.force)[1].mean(axis=0)
    edges = np.minimum(np.array(BANDS), f[-1])
    white = float(noise[problem.used].mean()) if problem.used.any() else 0.0
    total = max(float(power.mean(axis=0).sum()), 1e-300)
    regions = []
    for low, high in itertools.pairwise(edges):
        inside = (f >= low) & ((f < high) | (high >= f[-1]))
        if high <= low or not inside.any():
            continue
        sums = power[:, inside].sum(axis=1)
        square, quiet = float(sums.mean()), white * float(inside.mean())
        even = quiet + max(total - white, 0.0) * float(force[inside].sum() / force.sum())
        band = _band(sums, np.ones(sums.size), rng)
        ends = (float(low), float(high))
        regions.append(
            _region(
                "frequency",
                "Hz",
                ends,
                square / total,
                even / max(total, white),
                square,
                quiet,
                band,
            )
        )
    return RegionTable("frequency", "Hz", tuple(regions))
