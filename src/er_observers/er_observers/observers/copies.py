"""Copies and sums of arrays that compile at once: numba compiles `target[:] = source` with seconds of error texts."""

from __future__ import annotations

from er_models.model import Array

from er_observers.observers.compiled import compiled


@compiled
def copy(source: Array, target: Array) -> None:
    """Copy a matrix into another of its shape, row by row from the first on."""
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            target[i, j] = source[i, j]


@compiled
def copy_row(source: Array, target: Array) -> None:
    """Copy a vector into another of its length."""
    for i in range(source.shape[0]):
        target[i] = source[i]


@compiled
def add_row(source: Array, target: Array) -> None:
    """Add a vector to another of its length, in place."""
    for i in range(source.shape[0]):
        target[i] += source[i]


@compiled
def scale_row(factor: float, target: Array) -> None:
    """Multiply a vector, in place."""
    for i in range(target.shape[0]):
        target[i] *= factor


@compiled
def difference(a: Array, b: Array, out: Array) -> None:
    """Difference a - b of vectors into out."""
    for i in range(a.shape[0]):
        out[i] = a[i] - b[i]
