"""What is left by a model though noise would not leave it: an answer of linear filters, and bursts."""

from __future__ import annotations

import numpy as np
from er_models.model import Array
from numpy.typing import NDArray

from er_model_lab.problem.problem import Problem

LONGEST = 0.16
"""Memory of the filters [s]."""
MOST_ROWS = 20_000
RIDGE = 1e-3
WINDOW = 0.1
"""Length of the windows in which the power is looked at [s]."""
LOUD = 2.0
"""Power of a window over the calm level from which on it belongs to a burst."""
BURSTS = 0.1
"""Share of the power that must lie in bursts before they are believed."""

TWICE = 4.0
"""Most by which the power of the motion's errors may be larger than fusion claims: errors twice as large."""

Rows = NDArray[np.intp]


def filtered(
    problem: Problem, residual: Array, in_fit: Array
) -> tuple[float, float, dict[str, float]]:
    """What finite impulse responses of model force, velocity and duty change explain of a residual.

    Shares on unseen stretches of the training samples and on the held-out ones, and what each of the three
    is worth. A resonance of the frame or a pulse at each edge of the duty is small beside noise in every
    sample, and stands out in many.
    """
    m = problem.motion
    signals = {
        "model force, its past": problem.force - in_fit,
        "velocity, its past": m.v,
        "duty change, its past": np.diff(m.u, prepend=m.u[0]),
    }
    train, held = _thinned(problem.train), _thinned(problem.held_out)
    second = max(round(1.0 / m.dt), 1)
    columns = {name: _lags(y, train, m.dt) for name, y in signals.items()}
    target, groups = residual[train], (train // second) % 4
    share = _explained(np.hstack(list(columns.values())), target, groups)
    weights = _solved(np.hstack(list(columns.values())), in_fit[train])
    unseen = np.hstack([_lags(y, held, m.dt) for y in signals.values()])
    left = in_fit[held] - unseen @ weights
    kept = 1.0 - float(np.mean(left**2) / max(float(np.mean(in_fit[held] ** 2)), 1e-300))
    worth = {}
    if share > 0.0:
        for name in columns:
            others = np.hstack([y for other, y in columns.items() if other != name])
            worth[name] = share - _explained(others, target, groups)
    return share, kept, dict(sorted(worth.items(), key=lambda kv: -kv[1]))


def bursts(problem: Problem, residual: Array, input_square: Array, chance: float = 0.0) -> float:
    """Share of the residual's power that lies in bursts: above what noise does in any window.

    input_square (n,): mean square of the force error that the motion sensors cause, at each sample; where the
    gate closes it is large, and that is no burst. chance: largest share that such errors and noise made when drawn.
    Zero below that and `BURSTS`.
    """
    share = float(burst_shares(problem, residual[None], input_square)[0])
    return share if share > max(BURSTS, chance) else 0.0


def burst_shares(problem: Problem, errors: Array, input_square: Array) -> Array:
    """Shares (m,) of the power of errors (m, n) that lie in bursts; zero where the data are too short to say."""
    rows, length = np.flatnonzero(problem.train), max(round(WINDOW / problem.motion.dt), 8)
    many = rows.size // length * length
    if many < 20 * length:
        return np.zeros(errors.shape[0])
    rows = rows[:many]
    power = _windows(errors[:, rows] ** 2, length)
    moved = _windows(input_square[rows][None], length)
    mean = power.mean(axis=1, keepdims=True)
    moved = underrated(power, moved) * moved
    own = np.maximum(mean - moved.mean(axis=1, keepdims=True), 0.1 * mean)
    power = power / (np.maximum(own, 1e-300) + moved)
    calm = np.median(power, axis=1, keepdims=True) / (1.0 - 2.0 / (9.0 * length)) ** 3
    quiet = np.minimum(power, LOUD * calm).mean(axis=1)
    return np.asarray(1.0 - quiet / np.maximum(power.mean(axis=1), 1e-300))


def underrated(power: Array, moved: Array) -> Array:
    """By how much the power of the motion's errors is larger than claimed (m, 1): 1 to `TWICE`.

    power (m, windows): of the errors; moved (1, windows): what fusion claims. It takes its errors as evenly spread as
    the motion allows; where the gate closes they are larger. The power of the windows then rises by more than the
    claim, everywhere by the same factor, which bursts at other times do not: weighted least squares on a constant
    and the claim.
    """
    spread = moved - moved.mean()
    if not np.any(np.abs(spread) > 1e-9 * np.max(moved, initial=0.0)):
        return np.ones((power.shape[0], 1))
    mean = power.mean(axis=1, keepdims=True)
    level = np.maximum(mean - moved.mean(), 0.1 * mean) + moved
    weight = np.maximum(level, 1e-300) ** -2.0
    weight = weight / weight.sum(axis=1, keepdims=True)
    about = moved - (weight * moved).sum(axis=1, keepdims=True)
    slope = (weight * about * power).sum(axis=1) / (weight * about**2).sum(axis=1)
    return np.asarray(np.clip(slope, 1.0, TWICE)[:, None])


def _windows(y: Array, length: int) -> Array:
    """Means (m, windows) of windows of each row, side by side."""
    return np.asarray(y.reshape(y.shape[0], -1, length).mean(axis=2))


def _thinned(mask: NDArray[np.bool_]) -> Rows:
    """Places of a mask, at most so many."""
    rows = np.flatnonzero(mask)
    return rows[:: max(1, -(-rows.size // MOST_ROWS))]


def _lags(y: Array, rows: Rows, dt: float) -> Array:
    """A signal and its past (rows, lags), of unit size."""
    past = np.arange(max(round(LONGEST / dt), 1))
    size = max(float(np.std(y)), 1e-300)
    return np.asarray(y[np.maximum(rows[:, None] - past, 0)] / size)


def _solved(columns: Array, target: Array) -> Array:
    """Ridge regression."""
    normal = columns.T @ columns + RIDGE * columns.shape[0] * np.eye(columns.shape[1])
    return np.asarray(np.linalg.solve(normal, columns.T @ target))


def _explained(columns: Array, target: Array, groups: NDArray[np.intp]) -> float:
    """Share that is explained on groups left out."""
    left = target.copy()
    for g in range(int(groups.max(initial=0)) + 1):
        out = groups == g
        if out.any() and not out.all():
            left[out] -= columns[out] @ _solved(columns[~out], target[~out])
    return 1.0 - float(np.mean(left**2) / max(float(np.mean(target**2)), 1e-300))
