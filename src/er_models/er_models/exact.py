"""Definiteness of small matrices and their systems, in exact rational arithmetic.

Every double is a fraction, so a matrix made of doubles is known exactly, and so are its leading
minors. The answer is a proof, not an estimate: no rounding, no tolerance, no
trust in a solver.
"""

from __future__ import annotations

from fractions import Fraction
from math import lcm

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
    """Whether a symmetric matrix of fractions (n, n) is positive definite.

    By the leading minors, which Bareiss's elimination finds without division but for exact ones.
    """
    n = matrix.shape[0]
    if any(matrix[i, j] != matrix[j, i] for i in range(n) for j in range(i)):
        return False
    shared = lcm(*(value.denominator for value in matrix.ravel()))
    a = [[int(value * shared) for value in row] for row in matrix]
    before = 1
    for k in range(n):
        minor = a[k][k]
        if minor <= 0:
            return False
        for i in range(k + 1, n):
            for j in range(k + 1, n):
                a[i][j] = (a[i][j] * minor - a[i][k] * a[k][j]) // before
        before = minor
    return True


def solved(matrix: Exact, right: Exact) -> Exact:
    """Exact solution (n,) of a regular system of fractions (n, n), by Gauss and Jordan."""
    whole = np.column_stack([matrix, right])
    n = len(whole)
    for k in range(n):
        pivot = next(i for i in range(k, n) if whole[i, k] != 0)
        whole[[k, pivot]] = whole[[pivot, k]]
        whole[k] = whole[k] / whole[k, k]
        for i in range(n):
            if i != k and whole[i, k] != 0:
                whole[i] = whole[i] - whole[k] * whole[i, k]
    return np.asarray(whole[:, -1])
