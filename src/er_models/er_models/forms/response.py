"""Frequency responses of linear systems and where they peak."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from er_models.model import Array

Complex = NDArray[np.complex128]


class Peak(NamedTuple):
    """A largest value of a gain: frequency [Hz] and gain in the unit of the response."""

    hertz: float
    gain: float


def frequency_response(
    A: Array, B: Array, C: Array, hertz: Array, D: Array | None = None
) -> Complex:
    """C (j omega - A)^-1 B + D at frequencies (k,) [Hz], shape (k, outputs, inputs).

    A (n, n), B (n, inputs), C (outputs, n), D (outputs, inputs) or none.
    """
    pencils = 2j * np.pi * np.asarray(hertz)[:, None, None] * np.eye(A.shape[0]) - A
    states = np.linalg.solve(pencils, np.broadcast_to(B, (len(pencils), *B.shape)).astype(complex))
    return np.asarray(C @ states + (0.0 if D is None else D), np.complex128)


def peaks(hertz: Array, gain: Array) -> list[Peak]:
    """Peaks inside a range of rising frequencies (k,) [Hz], each from the parabola through three points."""
    found = []
    x, y = np.log(hertz), np.log(gain)
    for i in np.flatnonzero((y[1:-1] > y[:-2]) & (y[1:-1] >= y[2:])) + 1:
        c, b, a = np.polyfit(x[i - 1 : i + 2] - x[i], y[i - 1 : i + 2] - y[i], 2)[::-1]
        at = -b / (2.0 * a)
        top = c + b * at + a * at**2
        found.append(Peak(float(np.exp(x[i] + at)), float(np.exp(y[i] + top))))
    return found
