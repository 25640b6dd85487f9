"""The noise floor from several sides: standstill, repeated motion, the sensors, and what no regression explains.

None of them needs the others to be right, so they are shown side by side. Trees cannot predict what hangs on a state
that they do not see, nor what they saw too little of: they take an error of the model for noise. So a rest or a
repeated motion, where there is one, bounds what they say.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from er_models.model import Array
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from er_model_lab.diagnosis.noise_floor import Floor
from er_model_lab.problem.problem import Problem

REST = 0.3
"""Shortest rest that counts [s]."""
ENOUGH = 100
"""Samples at rest, or repeated ones, from which a floor is read."""
SETTLE = 0.1
"""Ends of a rest that are left out, since the motion creeps there [s]."""
STILL = 0.005
"""Velocity at rest, as a share of the largest."""
MEMORY, TAPS = 0.3, 8
"""Past over which two motions must agree to be the same [s], and at how many instants."""
ALIKE = 0.02
"""Difference of repeated motions and duties, as a share of their size, beside what the sensors' noise makes."""
APART = 0.5
"""Shortest time between a motion and its repeat [s]."""
MOST = 30_000
"""Samples looked at for repeats."""
AGREE = 1.15
"""Ratio up to which two estimates of the noise agree."""
SURE = 0.1
"""Standard deviation of an estimate, as a share of it, up to which it counts."""
GROUPS = 4
"""Groups of windows of time; repeats are sought in the others."""


@dataclass(frozen=True)
class Side:
    """One estimate of the noise [N] with its standard deviation; None with the reason where there is none."""

    value: float | None
    sd: float | None
    says: str

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return {"value": self.value, "sd": self.sd, "says": self.says}


def floors(problem: Problem, residual: Array, floor: Floor) -> dict[str, Side]:
    """All estimates; residual (n * outputs,): what the best model leaves [N]; the first output counts."""
    n, problem = problem.forward.outputs, problem.parts[0]
    at_rest = standstill(problem)
    moved = floor.input_error
    learnt = floor.learnt or (floor.floor, floor.held_out)
    return {
        "standstill": at_rest,
        "standstill_and_motion_sensors": _moving(at_rest, moved),
        "repeats": repeats(problem, residual[::n]),
        "force_white": Side(floor.white, None, "white part of what is left"),
        "motion_sensors": Side(moved, None, "errors of the motion sensors, through the model"),
        "bound": Side(learnt[1], None, "what trees and filters cannot explain, held-out data"),
        "bound_train": Side(learnt[0], None, "the same, training data"),
    }  # fmt: skip


def _moving(at_rest: Side, moved: float) -> Side:
    """Noise at rest together with what the errors of the motion sensors make [N]."""
    if at_rest.value is None:
        return Side(None, None, at_rest.says)
    return Side(float(np.hypot(at_rest.value, moved)), at_rest.sd, "both together")


def credible(floor: Floor, problem: Problem, residual: Array) -> Floor:
    """The floor that counts: that of trees and filters, or the noise that was measured, where that is clearly less.

    A rest shows the noise of the force; the motion sensors add to it. What samples differ by that repeat others is
    noise there, and what they have in common beside it is the model's; all samples together have no less than what
    the sensors make. residual (n,): what a model leaves [N].
    Of several outputs the floor stays as it is.
    """
    if problem.forward.outputs > 1:
        return floor
    sides = []
    rest, twice = _moving(standstill(problem), floor.input_error), _repeated(problem, residual)
    if rest.value is not None and rest.sd is not None and rest.sd <= SURE * rest.value:
        sides.append(rest.value)
    if isinstance(twice, Repeats) and twice.sd <= SURE * twice.noise:
        common = (
            max(twice.left**2 - twice.noise**2, 0.0) if twice.left > AGREE * twice.noise else 0.0
        )
        below = float(np.sqrt(max(floor.floor**2 - twice.share * common, twice.noise**2)))
        sides.append(max(below, floor.of_sensors))
    if not sides:
        return floor
    least = min(sides)
    if floor.floor <= AGREE * least:
        return replace(floor, measured=least)
    return replace(
        floor, floor=least, held_out=min(floor.held_out, least), measured=least, learnt=(floor.floor, floor.held_out)
    )  # fmt: skip


def standstill(problem: Problem) -> Side:
    """Noise of the force where neither motion nor duty change, slow creep aside."""
    m = problem.motion
    fused = float(np.mean([f.sd_v for f in problem.fused])) if problem.fused else 0.0
    still = np.abs(m.v) < max(STILL * float(np.quantile(np.abs(m.v), 0.995)), 4.0 * fused)
    still &= np.diff(m.u, prepend=m.u[0]) == 0.0
    # a drift within the threshold of the velocity is a slow motion, not a rest
    wander = max(10.0 * _noise_x(problem), 1e-4 * float(np.ptp(m.x)))
    least, left, lost = max(round(REST / m.dt), 20), [], 0
    edge = round(SETTLE / m.dt)
    for first, last in _runs(still, m.starts):
        i, j = first + edge, last - edge
        if j - i < least or np.ptp(m.x[i:j]) > wander:
            continue
        t = np.arange(j - i, dtype=np.float64)
        part = problem.force[i:j]
        left.append(part - np.polyval(np.polyfit(t, part, 1), t))
        lost += 2
    many = sum(e.size for e in left)
    if many < ENOUGH:
        return Side(None, None, f"no rest of {REST:g} s or more in these records")
    value = float(np.sqrt(sum(float(np.sum(e**2)) for e in left) / (many - lost)))
    return Side(
        value, float(value / np.sqrt(2.0 * (many - lost))), f"{many * m.dt:.3g} s at rest, stretches: {len(left)}"
    )  # fmt: skip


def _noise_x(problem: Problem) -> float:
    """Noise of the deflection [m], fused where it was."""
    return float(np.mean([f.sd_x for f in problem.fused])) if problem.fused else 1e-6


def _runs(mask: NDArray[np.bool_], starts: NDArray[np.int64]) -> list[tuple[int, int]]:
    """Runs [i, j) of True within a record."""
    found = []
    for a, b in itertools.pairwise(starts):
        edges = np.diff(np.concatenate([[False], mask[a:b], [False]]).astype(np.int8))
        first, last = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
        found += [(int(a + i), int(a + j)) for i, j in zip(first, last, strict=True)]
    return found


@dataclass(frozen=True)
class Repeats:
    """Samples that repeat others: how many, their share [1], noise with deviation, and what a model leaves [N]."""

    many: int
    share: float
    noise: float
    sd: float
    left: float


def repeats(problem: Problem, residual: Array) -> Side:
    """Noise from samples that have the same motion and duty behind them: half the mean square of their difference.

    The residuals are compared, not the forces: a model that is wrong is wrong by the same amount both times, and
    what the two motions still differ by is predicted well enough. What depends on more than the recent past
    (temperature, ageing) stays in it.
    """
    found = _repeated(problem, residual)
    if isinstance(found, str):
        return Side(None, None, found)
    says = f"{found.many} samples that repeat others ({found.share:.0%} of those looked at)"
    return Side(found.noise, found.sd, says)


def _repeated(problem: Problem, residual: Array) -> Repeats | str:
    """Samples that repeat others, or why there are none."""
    rows, points = _past(problem)
    if rows.size < ENOUGH:
        return "too short to hold a repeat"
    found = _partners(rows, points, problem)
    a, b = rows[found[0]], rows[found[1]]
    if a.size < ENOUGH:
        return "no motion is repeated in these records"
    half = 0.5 * (residual[a] - residual[b]) ** 2
    value = float(np.sqrt(np.mean(half)))
    _, block = np.unique(a // problem.second, return_inverse=True)
    means = np.bincount(block, half) / np.bincount(block)
    sd = float(np.std(means) / np.sqrt(means.size) / max(2.0 * value, 1e-300))
    left = float(np.sqrt(np.mean(residual[a] ** 2)))
    return Repeats(int(a.size), a.size / rows.size, value, sd, left)


def _partners(
    rows: NDArray[np.intp], points: Array, problem: Problem
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Places of samples and of the nearest repeat of each, at another time.

    Each sample's neighbours in time are as near as its repeats, so time is cut into windows that belong to one of
    several groups by chance, and repeats are sought in the other groups.
    """
    second = problem.motion.starts.searchsorted(rows, side="right") * 10**7
    window = (rows + second) // max(round(APART / problem.motion.dt), 1)
    names, place = np.unique(window, return_inverse=True)
    group = np.random.default_rng(0).integers(0, GROUPS, names.size)[place]
    partner = np.full(rows.size, -1)
    for g in range(GROUPS):
        inside = np.flatnonzero(group == g)
        asks = np.flatnonzero((group != g) & (partner < 0))
        if not inside.size or not asks.size:
            continue
        near = cKDTree(points[inside]).query(points[asks], p=np.inf, distance_upper_bound=1.0)[1]
        hit = near < inside.size
        a, b = asks[hit], inside[near[hit]]
        far = np.abs(window[a] - window[b]) > 1
        partner[a[far]] = b[far]
    own = np.flatnonzero(partner >= 0)
    return own, partner[own]


def _past(problem: Problem) -> tuple[NDArray[np.intp], Array]:
    """Rows that may have a repeat, and motion and duty behind each (rows, features), 1 where no more alike."""
    m = problem.motion
    reach = round(MEMORY / m.dt)
    lags = np.unique(np.linspace(0, reach, TAPS).round().astype(int))
    rows = np.concatenate(
        [np.flatnonzero(problem.used[a:b])[reach:] + a for a, b in itertools.pairwise(m.starts)]
    )
    rows = rows[:: max(1, -(-rows.size // MOST))]
    sd_x, sd_v = _noise_x(problem), 0.0
    if problem.fused:
        sd_v = float(np.mean([f.sd_v for f in problem.fused]))
    size = {"x": float(np.std(m.x)), "v": float(np.std(m.v)), "u": float(np.max(np.abs(m.u)))}
    like = {
        "x": max(ALIKE * size["x"], 4.0 * sd_x), "v": max(ALIKE * size["v"], 4.0 * sd_v),
        "u": max(ALIKE * size["u"], 1e-9),
    }  # fmt: skip
    columns = [m.x[rows] / max(like["x"], 1e-12)]
    for lag in lags:
        columns += [m.v[rows - lag] / max(like["v"], 1e-12), m.u[rows - lag] / like["u"]]
    return rows, np.stack(columns, axis=1)
