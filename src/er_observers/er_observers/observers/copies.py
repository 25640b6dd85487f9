"""A copy of a matrix that compiles at once: numba compiles `target[:] = source` with seconds of error texts."""

from __future__ import annotations

from er_models.model import Array

from er_observers.observers.compiled import compiled


@compiled
def copy(source: Array, target: Array) -> None:
    """Copy a matrix into another of its shape, row by row from the first on."""
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            target[i, j] = source[i, j]
