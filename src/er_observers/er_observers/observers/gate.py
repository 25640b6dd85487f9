r"""The gate tanh s between two values of s: its mean, and the scalar equation of a substep, compiled.

.. math::  \bar\varphi = \frac{\ln\cosh s_1 - \ln\cosh s_0}{s_1 - s_0}

integrates a passage through the steep part exactly, however few steps it takes, and keeps the slope
in [0, 1] that the certificate rests on. The end value solves one scalar equation, monotone, by Halley's
method within a bracket.

Source: Quispel and McLaren 2008 (average vector field).
"""

from __future__ import annotations

import math

from er_observers.observers.compiled import compiled

_NEAR = 1e-3
"""Passages shorter than this are a Taylor series of the mean; its next term is below 1e-13."""
_SATURATED = 15.0
"""From here on the gate is taken as one; what that leaves out of a mean is below 1e-10."""
_ENOUGH = 1e-4
"""Step of the root's search, as a share of 1 + |s|, whose cube is nothing."""


@compiled
def gate_of(s: float) -> tuple[float, float]:
    """Gate tanh s, and its integral ln cosh s up to a constant; one exponential for both."""
    size = abs(s)
    if size > _SATURATED:
        return math.copysign(1.0, s), size
    fall = math.exp(-2.0 * size)
    return math.copysign((1.0 - fall) / (1.0 + fall), s), size + math.log(1.0 + fall)


@compiled
def _mean(step: float, t_0: float, area: float, t_1: float) -> tuple[float, float, float]:
    """Mean of the gate over a passage of length step, and its first two derivatives by the end.

    t_0, t_1: gate at its start and end; area: integral of the gate along it.
    """
    if abs(step) < _NEAR:
        slope = 1.0 - t_0 * t_0
        bend = -2.0 * t_0 * slope
        third = (6.0 * t_0 * t_0 - 2.0) * slope
        mean = t_0 + step * (slope / 2.0 + step * (bend / 6.0 + step * third / 24.0))
        first = slope / 2.0 + step * (bend / 3.0 + step * third / 8.0)
        return mean, first, bend / 3.0 + step * third / 4.0
    share = 1.0 / step
    mean = area * share
    first = (t_1 - mean) * share
    return mean, first, (1.0 - t_1 * t_1 - 2.0 * first) * share


@compiled
def mean_gate(s_0: float, s_1: float) -> tuple[float, float]:
    """Mean of tanh between s_0 and s_1, and its derivative by s_1 (0 to 1/2)."""
    t_0, area_0 = gate_of(s_0)
    t_1, area_1 = gate_of(s_1)
    mean, slope, _ = _mean(s_1 - s_0, t_0, area_1 - area_0, t_1)
    return mean, slope


@compiled
def slopes_of(s_0: float, t_0: float, s_1: float, t_1: float, mean: float) -> tuple[float, float]:
    """Derivatives of the mean by the start and by the end of a passage; t_0, t_1: the gate there."""
    area = mean * (s_1 - s_0)
    return _mean(s_0 - s_1, t_1, -area, t_0)[1], _mean(s_1 - s_0, t_0, area, t_1)[1]


@compiled
def solve_gate(
    s_0: float, t_0: float, area_0: float, free: float, gain: float
) -> tuple[float, float, float, float]:
    """Root s_1 of ``s_1 = free + gain * mean_gate(s_0, s_1)`` for gain < 2: s_1, `gate_of` it, the mean.

    t_0, area_0: `gate_of` s_0. From s_0 by Halley's method within a bracket; where its steps do not
    halve, bisection.
    """
    s_1 = free + gain * t_0
    if abs(t_0) == 1.0 and s_1 * t_0 > _SATURATED:
        return s_1, t_0, abs(s_1), t_0
    reach = abs(gain) + 1e-9 * (1.0 + abs(gain) + abs(free))  # a saturated gate's root lies inside
    low, high = free - reach, free + reach
    s_1 = s_0 + (s_1 - s_0) / (1.0 - 0.5 * gain * (1.0 - t_0 * t_0))
    s_1 = min(max(s_1, low), high)
    before = 2.0 * (high - low)
    t_1, area_1 = gate_of(s_1)
    mean = t_0
    for _ in range(100):
        mean, slope, bend = _mean(s_1 - s_0, t_0, area_1 - area_0, t_1)
        residual, rise = s_1 - free - gain * mean, 1.0 - gain * slope
        if residual > 0.0:
            high = s_1
        else:
            low = s_1
        step = (
            -residual * rise / max(rise * rise + 0.5 * residual * gain * bend, 0.5 * rise * rise)
        )
        if abs(step) <= _ENOUGH * (1.0 + abs(s_1)):
            half, along = 0.5 * step, 1.0 - t_1 * t_1
            area_1 += step * (t_1 + half * along)
            t_1 += step * along * (1.0 - step * t_1)
            return s_1 + step, t_1, area_1, mean + step * (slope + half * bend)
        if not low < s_1 + step < high or abs(step) > 0.5 * before:
            step = 0.5 * (low + high) - s_1
        s_1 += step
        before = abs(step)
        t_1, area_1 = gate_of(s_1)
    return s_1, t_1, area_1, mean
