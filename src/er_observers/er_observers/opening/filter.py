r"""The filter of the start phase: second-order central differences, with a road that may be rougher than thought.

The model moves 2 n + 1 points, the estimate and two along each root of the covariance, h standard deviations away;
mean and covariance are those of the parabolas through them. h = sqrt(3) suits a Gaussian and a smooth model best; the
gate is neither, and points further out see that it closes on both sides.

A road of white rate is no step: where the innovations are far beyond what the covariance allows, the road, not the
start, is blamed, and its noise grows until they are not.

Source: Norgaard, Poulsen and Ravn 2000 (DD2); innovation test: Bar-Shalom, Li and Kirubarajan 2001, 11.2.
"""

from __future__ import annotations

import math

import numpy as np
from er_models.model import Array

from er_observers.filters.correct import correct
from er_observers.filters.flow import flow
from er_observers.filters.unscented import points_about
from er_observers.observers.compiled import compiled
from er_observers.observers.copies import copy

H_2 = 6.5
"""Square of the reach of the points, in standard deviations; from 5 to 8 the errors from drawn starts are alike."""
FAR = 4.0
"""Mean square of the innovations over their variance from which the road is blamed."""


@compiled
def predict(
    linear: Array, kick: Array, gamma: Array, noise: Array, duty: float, x: Array, P: Array
) -> None:
    """Move x (n,) and P (n, n) one substep on, in place; noise (n, n) comes at its end."""
    n = x.shape[0]
    points = np.empty((2 * n + 1, n))
    points_about(x, P, math.sqrt(H_2), points)
    for i in range(n):
        points[2 * n, i] = x[i]
    for k in range(2 * n + 1):
        flow(linear, kick, gamma, duty, points[k])
    copy(noise, P)
    straight, bent = 0.25 / H_2, 0.25 * (H_2 - 1.0) / H_2**2
    middle = points[2 * n]
    for i in range(n):
        x[i] = middle[i]
        for k in range(n):
            up, down = points[k, i], points[n + k, i]
            x[i] += 0.5 / H_2 * (up + down - 2.0 * middle[i])
            for j in range(i + 1):
                u, d = points[k, j], points[n + k, j]
                bend = (up + down - 2.0 * middle[i]) * (u + d - 2.0 * middle[j])
                P[i, j] += straight * (up - down) * (u - d) + bent * bend
        for j in range(i):
            P[j, i] = P[i, j]


@compiled
def start_sample(
    linear: Array, kick: Array, gamma: Array, noise: Array, C: Array, variance: Array,
    duty: float, steps: int, y: Array, x: Array, P: Array,
) -> None:  # fmt: skip
    """Predict over all substeps of a sample, then correct by y (m,) where it is finite; x and P in place."""
    for _ in range(steps):
        predict(linear, kick, gamma, noise, duty, x, P)
    if np.isfinite(y).all():
        predicted, spread = x.copy(), P.copy()
        far = correct(C, variance, y, x, P) / FAR
        if steps > 0 and far > 1.0:
            for i in range(x.shape[0]):
                x[i] = predicted[i]
                for j in range(x.shape[0]):
                    P[i, j] = spread[i, j] + far * steps * noise[i, j]
            correct(C, variance, y, x, P)
