r"""Whether one channel is the derivative of another: by what factor, and how much later.

Where two channels are coherent, z = g d^k y / dt^k, delayed by T, has

.. math:: \frac{S_{y^{(k)} z}}{S_{y^{(k)} y^{(k)}}} = g e^{-i\omega T}.

The derivative is taken by central differences, whose own response is divided out. The size of g comes from
the ratio of the two powers, which noise of either channel moves in opposite directions, sign and delay from the
phase (Bendat and Piersol, Random Data, ch. 6 and 9).

A derivative raises noise with the frequency, and a segment of so many samples is short in time where the rate is high:
motion that is slow beside the rate is seen at a lower one only. So both channels are halved in rate, through the same
filter, until they have something in common.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from er_model_lab.filtering import cross, low_pass, welch

Array = NDArray[np.float64]

SEGMENT = 512
"""Samples of a segment of Welch's method."""
SHORTEST = 32
"""Samples below which a segment says nothing."""
COHERENT = 0.8
"""Squared coherence from which on a frequency counts, where chance alone does not reach as far."""
CHANCE = 1e-4
"""Share of lines that may count though the channels are independent."""
LOWEST, FEW_PERIODS = 3, 1
"""First line that counts: below, the trend of a segment leaks in; and that of records too short for it."""
UNMISTAKABLE = 0.5
"""Phase of a delay [rad] up to which it cannot be a turned sign, in a record of few periods."""
CARRIED = 0.5
"""Share of the power that must lie in lines that count."""


@dataclass(frozen=True)
class Relation:
    """z = gain d^k y / dt^k delayed by `delay` [s], each with a standard deviation.

    lines: frequencies used; dt: sample time [s] of the rate at which they were seen.
    """

    gain: float
    gain_sd: float
    delay: float
    delay_sd: float
    lines: int
    dt: float


def relate(y: Array, z: Array, order: int, dt: float, highest: float = np.inf) -> Relation | None:
    """Relation of two channels (n,) up to `highest` [Hz], at the highest rate at which they have one; else None."""
    rates = list(_rates(y, z, dt))
    # of the many lines at a record's own rate, half of the power is beyond chance
    tries = [(rate, LOWEST, COHERENT) for rate in rates[:1]]
    tries += [(rate, k, _least(rate[0].size)) for k in (LOWEST, FEW_PERIODS) for rate in rates]
    found = (_at_rate(*rate, order, highest, k, least) for rate, k, least in tries)
    return next((relation for relation in found if relation is not None), None)


def _rates(y: Array, z: Array, dt: float) -> Iterator[tuple[Array, Array, float]]:
    """Two channels and their sample time at their own rate, half of it, and so on."""
    while y.size >= 3 * SHORTEST:
        yield y, z, dt
        y, z, dt = _halved(y), _halved(z), 2.0 * dt


@cache
def _half_band() -> Array:
    """Taps of the filter before each halving of the rate: what would fold onto frequencies that count loses 60 dB."""
    return low_pass(19, 0.5, 6.0)


def _halved(y: Array) -> Array:
    """A channel at half its rate, without the ends that the filter does not fill."""
    return np.asarray(np.convolve(y, _half_band(), "valid")[::2])


def _length(n: int) -> int:
    """Samples of a segment of n samples."""
    return min(SEGMENT, n // 3)


def _least(n: int) -> float:
    """Squared coherence from which on a line of n samples counts: independent channels exceed it in a share `CHANCE`.

    Segments that overlap by half count 1.4 times those laid end to end with Hann's window.
    """
    return max(COHERENT, 1.0 - float(CHANCE ** (1.0 / (1.4 * n / _length(n) - 1.0))))


def _at_rate(
    y: Array, z: Array, dt: float, order: int, highest: float, lowest: int, least: float
) -> Relation | None:
    """Relation at the rate the channels have, of lines from `lowest` on with a squared coherence above `least`."""
    length = _length(y.size)
    slope, z = _difference(y, order, dt), z[1:-1]
    f, shared = cross(slope, z, 1.0 / dt, length)
    _, p_y = welch(slope, 1.0 / dt, length)
    _, p_z = welch(z, 1.0 / dt, length)
    coherence = np.abs(shared) ** 2 / np.maximum(p_y * p_z, 1e-300)
    use = (np.arange(f.size) >= lowest) & (coherence > least) & (f < min(highest, 0.25 / dt))
    # lines that are coherent only by leakage of a slower tone say nothing
    if not use.any() or p_y[use].sum() < CARRIED * p_y.sum():
        return None
    w, c = 2.0 * np.pi * f[use], np.minimum(coherence[use], 1.0 - 1e-6)
    averages = max(y.size / length, 1.0)
    variance = (1.0 - c) / (2.0 * c * averages)
    # strong lines first: beside them, leakage of their neighbours counts for little
    weight = p_y[use] / variance
    size = np.sqrt(p_z[use] / p_y[use]) * _response(w * dt, order)
    phase = np.angle(shared[use])
    sign, delay = _phase(w, phase, weight)
    share = weight / weight.sum()
    # half a period late or turned: of a few periods, nothing tells
    if lowest < LOWEST and abs(delay) * float(np.sum(share * w)) > UNMISTAKABLE:
        return None
    gain = float(np.exp(np.sum(share * np.log(size))))
    # noise of y alone would make it too small by the root of the coherence, noise of z alone too large
    between = float(np.sum(share * (1.0 / np.sqrt(c) - np.sqrt(c)))) / 2.0 / np.sqrt(3.0)
    spread = float(np.hypot(np.sqrt(np.sum(share**2 * variance)), between))
    lever = np.sum(weight * w**2)
    delay_sd = float(np.sqrt(np.sum((weight * w) ** 2 * variance)) / lever)
    return Relation(sign * gain, gain * spread, delay, delay_sd, int(use.sum()), dt)


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
