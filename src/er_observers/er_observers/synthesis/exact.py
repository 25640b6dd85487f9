"""Definiteness of small matrices, decided in exact rational arithmetic.

Every double is a fraction, so a matrix made of doubles is known exactly, and so are the pivots of
its ``L D L'`` factorisation. The answer is a proof, not an estimate: no rounding, no tolerance, no
trust in a solver.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

Exact = NDArray[np.object_]


def exact(values: object) -> Exact:
    """Array of doubles as an array of fractions of equal shape."""
    floats = np.asarray(values, float)
    return np.array([Fraction(float(v)) for v in floats.ravel()], dtype=object).reshape(
        floats.shape
    )


def is_positive_definite(matrix: Exact) -> bool:
    """Whether a symmetric matrix of fractions (n, n) is positive definite."""
    a = matrix.copy()
    n = a.shape[0]
    if any(a[i, j] != a[j, i] for i in range(n) for j in range(i)):
        return False
    for k in range(n):
        if not a[k, k] > 0:
            return False
        for i in range(k + 1, n):
            factor = a[i, k] / a[k, k]
            for j in range(k, n):
                a[i, j] = a[i, j] - factor * a[k, j]
    return True
