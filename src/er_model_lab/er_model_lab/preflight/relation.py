r"""Whether one channel is the derivative of another: by what factor, and how much later.

Where two channels are coherent, z = g d^k y / dt^k, delayed by T, has

.. math:: \frac{S_{y^{(k)} z}}{S_{y^{(k)} y^{(k)}}} = g e^{-i\omega T}.

The derivative is taken by central differences, whose own response is divided out. The size of g comes from
the ratio of the two powers, which noise of either channel moves in opposite directions, sign and delay from the
phase (Bendat and Piersol, Random Data, ch. 6 and 9).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import csd, welch

Array = NDArray[np.float64]

SEGMENT = 512
"""Samples of a segment of Welch's method."""
COHERENT = 0.8
"""Squared coherence from which on a frequency counts."""
CARRIED = 0.5
"""Share of the power that must lie in frequencies that count."""
LOWEST = 3
"""First frequency that counts, in lines: below, the trend of a segment leaks in."""


@dataclass(frozen=True)
class Relation:
    """z = gain d^k y / dt^k delayed by `delay` [s], each with a standard deviation; lines: frequencies used."""

    gain: float
    gain_sd: float
    delay: float
    delay_sd: float
    lines: int


def relate(y: Array, z: Array, order: int, dt: float, highest: float = np.inf) -> Relation | None:
    """Relation of two channels (n,) up to `highest` [Hz]; None where they have nothing in common."""
    length = min(SEGMENT, y.size // 3)
    if length < 32:
        return None
    slope, z = _difference(y, order, dt), z[1:-1]
    f, cross = csd(slope, z, 1.0 / dt, nperseg=length)
    _, p_y = welch(slope, 1.0 / dt, nperseg=length)
    _, p_z = welch(z, 1.0 / dt, nperseg=length)
    coherence = np.abs(cross) ** 2 / np.maximum(p_y * p_z, 1e-300)
    use = (np.arange(f.size) >= LOWEST) & (coherence > COHERENT) & (f < min(highest, 0.25 / dt))
    # lines that are coherent only by leakage of a slower tone say nothing
    if not use.any() or p_y[use].sum() < CARRIED * p_y.sum():
        return None
    w, c = 2.0 * np.pi * f[use], np.minimum(coherence[use], 1.0 - 1e-6)
    averages = max(y.size / length, 1.0)
    variance = (1.0 - c) / (2.0 * c * averages)
    # strong lines first: beside them, leakage of their neighbours counts for little
    weight = p_y[use] / variance
    size = np.sqrt(p_z[use] / p_y[use]) * _response(w * dt, order)
    phase = np.angle(cross[use])
    sign, delay = _phase(w, phase, weight)
    share = weight / weight.sum()
    gain = float(np.exp(np.sum(share * np.log(size))))
    # noise of y alone would make it too small by the root of the coherence, noise of z alone too large
    between = float(np.sum(share * (1.0 / np.sqrt(c) - np.sqrt(c)))) / 2.0 / np.sqrt(3.0)
    spread = float(np.hypot(np.sqrt(np.sum(share**2 * variance)), between))
    lever = np.sum(weight * w**2)
    delay_sd = float(np.sqrt(np.sum((weight * w) ** 2 * variance)) / lever)
    return Relation(sign * gain, gain * spread, delay, delay_sd, int(use.sum()))


def _difference(y: Array, order: int, dt: float) -> Array:
    """First or second derivative (n - 2,) by central differences."""
    if order == 1:
        return np.asarray((y[2:] - y[:-2]) / (2.0 * dt))
    return np.asarray((y[2:] - 2.0 * y[1:-1] + y[:-2]) / dt**2)


def _response(angle: Array, order: int) -> Array:
    """What central differences make of a derivative, over angle per sample (lines,)."""
    if order == 1:
        return np.asarray(np.sin(angle) / angle)
    return np.asarray((2.0 - 2.0 * np.cos(angle)) / angle**2)


def _phase(w: Array, phase: Array, weight: Array) -> tuple[float, float]:
    """Sign and delay [s] that explain a phase (lines,) best."""
    best = (np.inf, 1.0, 0.0)
    for sign in (1.0, -1.0):
        turned = np.angle(np.exp(1j * phase) * sign)
        delay = -float(np.sum(weight * w * turned) / np.sum(weight * w**2))
        # a second look resolves delays of more than half a period of the fastest line
        left = np.angle(np.exp(1j * (turned + w * delay)))
        delay -= float(np.sum(weight * w * left) / np.sum(weight * w**2))
        left = np.angle(np.exp(1j * (turned + w * delay)))
        error = float(np.sum(weight * left**2))
        if error < best[0]:
            best = (error, sign, delay)
    return best[1], best[2]
