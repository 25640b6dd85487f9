"""What physics says of columns: which is a time, which the derivative of which, and whether a force dissipates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from er_records.record import Array
from er_records.timing import timing_of

COHERENT = 0.95
"""Correlation from which on one column is the derivative of another."""
CENTRED = 1.0
"""Largest mean of a derivative, over its root mean square about it."""
SMOOTHED = 5
"""Samples of the mean that takes the noise off a difference."""
STEADY = 0.5
"""Share of a step by which steps of time may differ from the usual one, for nine of ten of them."""


@dataclass(frozen=True)
class Derivative:
    """A column as the derivative of another: is_ = gain * d of / dt, with their correlation.

    mean: of the column less that of the slope, over its root mean square about its mean; a sensor's voltage has one.
    """

    gain: float
    correlation: float
    mean: float = 0.0

    @property
    def holds(self) -> bool:
        """Whether it is one."""
        return abs(self.correlation) >= COHERENT and abs(self.mean) <= CENTRED


def is_time(y: Array) -> bool:
    """Whether samples (n,) rise steadily."""
    step = np.diff(y)
    if y.size < 10 or not np.isfinite(y).all() or np.any(step < 0.0):
        return False
    usual = float(np.median(step))
    near = np.abs(step - usual) <= STEADY * usual
    return usual > 0.0 and float(np.mean(near)) > 0.9


def rate_of(t: Array) -> float:
    """Rate of a time axis (n,) [1 over its unit]."""
    step = timing_of(t).dt if t.size > 1 else 0.0
    return 1.0 / step if step > 0.0 else float("nan")


def derivative(of: Array, is_: Array, t: Array) -> Derivative:
    """How far samples (n,) are the derivative of others at times t (n,) [s]."""
    slope, y = velocity(of, t), smooth(is_)
    (drift, mean), slope, y = (slope.mean(), y.mean()), slope - slope.mean(), y - y.mean()
    power, own = float(slope @ slope), float(y @ y)
    if power <= 0.0 or not own > 0.0:
        return Derivative(0.0, 0.0)
    both = float(slope @ y)
    off = float(mean - both / power * drift) / float(np.sqrt(own / y.size))
    return Derivative(both / power, both / float(np.sqrt(power * own)), off)


def dissipation(force: Array, v: Array) -> float:
    """Power that a force takes out of a motion over all that it moves, -1 to 1; (n,) each."""
    f = smooth(force)
    f = f - 0.5 * (np.quantile(f, 0.02) + np.quantile(f, 0.98))
    power = f * v
    whole = float(np.abs(power).sum())
    return float(power.sum()) / whole if whole > 0.0 else 0.0


def velocity(x: Array, t: Array) -> Array:
    """Slope of a motion (n,)."""
    return np.asarray(np.gradient(smooth(x), t))


def smooth(y: Array) -> Array:
    """Running mean (n,), missing samples bridged."""
    good = np.isfinite(y)
    if not good.all():
        y = np.interp(np.arange(y.size), np.flatnonzero(good), y[good])
    padded = np.pad(y, SMOOTHED // 2, mode="edge")
    return np.convolve(padded, np.full(SMOOTHED, 1.0 / SMOOTHED), mode="valid")


def is_switched(y: Array) -> bool:
    """Whether samples (n,) hold a few values above zero, as a duty does."""
    good = y[np.isfinite(y)]
    span = float(np.ptp(good)) if good.size else 0.0
    if span <= 0.0 or good.min() < -0.05 * span:
        return False
    return float(np.mean(np.abs(np.diff(good)) <= 0.02 * span)) > 0.9
