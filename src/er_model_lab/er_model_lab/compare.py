"""Predict, compare, and say where the model fails."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from er_models.model import Array
from numpy.typing import NDArray
from scipy.signal import lfilter

from er_model_lab.prepare import Problem
from er_model_lab.view import Region, RegionTable

QUANTILES = (0.0, 0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.98, 1.0)
"""Edges of the bins: fine at both ends, where stops and cut-offs show."""
LEVELS = 6
"""A quantity with so few values gets a bin for each."""
BOOTSTRAPS = 200


@dataclass(frozen=True)
class Errors:
    """Errors over a mask: root mean square [N], and over the range of the measured force (3.79)."""

    rmse: float
    nrmse: float


def errors(problem: Problem, residual: Array, mask: NDArray[np.bool_]) -> Errors:
    """RMSE [N] and NRMSE = RMSE / (max - min of the force), thesis (3.79)-(3.80); of the first output."""
    n = problem.forward.outputs
    y, e, mask = problem.force[::n], residual[::n], mask[::n]
    rmse = float(np.sqrt(np.mean(e[mask] ** 2))) if mask.any() else float("nan")
    span = float(np.ptp(y[mask])) if mask.any() else float("nan")
    return Errors(rmse, rmse / span if span > 0 else float("nan"))


def region_tables(problem: Problem, residual: Array, seed: int) -> tuple[RegionTable, ...]:
    """Error against deflection, velocity, acceleration, duty, duty rate, time, work done, direction, frequency."""
    n, problem = problem.forward.outputs, problem.parts[0]
    residual, m = residual[::n], problem.motion
    rate = np.concatenate([[0.0], np.diff(m.u)]) / m.dt
    recent = np.asarray(lfilter([1.0], [1.0, -np.exp(-m.dt / 0.05)], np.abs(rate) * m.dt))
    recent = np.where(recent < 1e-3, 0.0, recent)
    force = problem.force - residual
    work = np.concatenate(
        [np.cumsum(np.abs(force[i:j] * m.v[i:j])) * m.dt for i, j in _pairs(problem)]
    )
    quantities: list[tuple[str, str, Array]] = [
        ("deflection", "m", m.x), ("velocity", "m/s", m.v), ("acceleration", "m/s2", m.a), ("duty", "1", m.u),
        ("duty change in the last 50 ms", "1", recent), ("time", "s", m.t), ("work done", "J", work),
        ("direction", "1", np.sign(m.v)),
    ]  # fmt: skip
    if np.ptp(m.theta) > 0.5:
        quantities.append(("temperature", "K", m.theta))
    rng = np.random.default_rng(seed)
    tables = [_table(problem, residual, name, unit, y, rng) for name, unit, y in quantities]
    tables.append(_frequency_table(problem, residual))
    return tuple(t for t in tables if len(t.regions) > 1)


def worst(tables: tuple[RegionTable, ...], most: int = 8) -> list[dict[str, object]]:
    """The region of each quantity that carries far more error than its share of samples, heaviest first."""
    heavy = [
        [r for r in t.regions if r.share > 1.3 * r.of_samples and r.share > 0.05] for t in tables
    ]
    regions = [max(group, key=lambda r: r.share - r.of_samples) for group in heavy if group]
    regions.sort(key=lambda r: r.share - r.of_samples, reverse=True)
    return [
        {
            "quantity": r.quantity, "unit": r.unit, "from": r.edges[0], "to": r.edges[1], "share": r.share,
            "of_samples": r.of_samples, "rmse": r.rms, "band": list(r.band),
        }
        for r in regions[:most]
    ]  # fmt: skip


def _pairs(problem: Problem) -> list[tuple[int, int]]:
    """First and last row of each record."""
    s = problem.motion.starts
    return [(int(i), int(j)) for i, j in itertools.pairwise(s)]


def _table(
    problem: Problem, residual: Array, name: str, unit: str, y: Array, rng: np.random.Generator
) -> RegionTable:
    """Squared error over quantile bins of a quantity, with a bootstrap over one-second blocks."""
    rows = np.flatnonzero(problem.used)
    values, squared = y[rows], residual[rows] ** 2
    levels = np.unique(np.round(values, 12))
    if levels.size <= LEVELS:
        edges = np.concatenate([levels, [levels[-1]]])
        place = np.searchsorted(levels, np.round(values, 12))
    else:
        edges = np.unique(np.quantile(values, QUANTILES))
        place = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, edges.size - 2)
    blocks = rows // max(round(1.0 / problem.motion.dt), 1)
    regions = []
    total = float(squared.sum())
    for b in range(int(place.max()) + 1 if place.size else 0):
        inside = place == b
        if not inside.any():
            continue
        regions.append(
            Region(
                name, unit, (float(edges[b]), float(edges[min(b + 1, edges.size - 1)])),
                float(squared[inside].sum() / max(total, 1e-300)), float(inside.mean()),
                float(np.sqrt(squared[inside].mean())), _band(squared[inside], blocks[inside], rng),
            )
        )  # fmt: skip
    return RegionTable(name, unit, tuple(regions))


def _band(
    squared: Array, blocks: NDArray[np.int64], rng: np.random.Generator
) -> tuple[float, float]:
    """90 % interval of the rms over resampled one-second blocks."""
    _, place = np.unique(blocks, return_inverse=True)
    sums = np.bincount(place, squared)
    counts = np.bincount(place)
    picks = rng.integers(0, sums.size, (BOOTSTRAPS, sums.size))
    rms = np.sqrt(sums[picks].sum(axis=1) / counts[picks].sum(axis=1))
    low, high = np.quantile(rms, [0.05, 0.95])
    return float(low), float(high)


def _frequency_table(problem: Problem, residual: Array) -> RegionTable:
    """Share of the residual's power in bands of frequency."""
    edges = np.array([0.0, 1.0, 2.0, 5.0, 10.0, 20.0, 40.0, 1e9])
    nyquist = 0.5 / problem.motion.dt
    power = np.zeros(edges.size - 1)
    for i, j in _pairs(problem):
        e = residual[i:j]
        spectrum = np.abs(np.fft.rfft((e - e.mean()) * np.hanning(e.size))) ** 2
        f = np.fft.rfftfreq(e.size, problem.motion.dt)
        power += np.bincount(
            np.searchsorted(edges, f, side="right") - 1, spectrum, edges.size - 1
        )[: power.size]
    total = max(float(power.sum()), 1e-300)
    rms = float(np.sqrt(np.mean(residual[problem.used] ** 2)))
    regions = []
    for b in range(power.size):
        if edges[b] >= nyquist:
            break
        top = min(float(edges[b + 1]), nyquist)
        level = rms * float(np.sqrt(power[b] / total))
        share = float(power[b] / total)
        width = (top - float(edges[b])) / nyquist
        regions.append(
            Region("frequency", "Hz", (float(edges[b]), top), share, width, level, (level, level))
        )
    return RegionTable("frequency", "Hz", tuple(regions))
