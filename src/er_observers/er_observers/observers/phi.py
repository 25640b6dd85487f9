"""Functions phi_0 = exp, phi_1 and phi_2 of a matrix, compiled: the exact linear part of a step.

Source: Hochbruck and Ostermann 2010.
"""

from __future__ import annotations

import numpy as np
from er_models.model import Array

from er_observers.observers.compiled import compiled
from er_observers.observers.copies import copy

_TERMS = 13


@compiled
def _multiply(a: Array, b: Array, out: Array) -> None:
    """Product a b of square matrices (n, n) into out."""
    n = a.shape[0]
    for i in range(n):
        for j in range(n):
            out[i, j] = 0.0
        for k in range(n):
            factor = a[i, k]
            for j in range(n):
                out[i, j] += factor * b[k, j]


@compiled
def _small_phi(a: Array, phi: Array, product: Array) -> None:
    """Fill phi (3, n, n) for a matrix a (n, n) of norm below one, by Taylor series."""
    n = a.shape[0]
    phi[2, :, :] = 0.0
    for k in range(_TERMS, 1, -1):  # Horner: phi_2 = sum of a^j / (j + 2)!
        _multiply(a, phi[2], product)
        for i in range(n):
            for j in range(n):
                phi[2, i, j] = (product[i, j] + (1.0 if i == j else 0.0)) / k
    for level in range(1, -1, -1):
        _multiply(a, phi[level + 1], phi[level])
        for i in range(n):
            phi[level, i, i] += 1.0


@compiled
def _double_phi(phi: Array, square: Array, product: Array) -> None:
    """From phi of a to phi of 2 a, in place."""
    n = square.shape[0]
    _multiply(phi[1], phi[1], square)
    _multiply(phi[0], phi[1], product)
    for i in range(n):
        for j in range(n):
            phi[2, i, j] = 0.25 * (square[i, j] + 2.0 * phi[2, i, j])
            phi[1, i, j] = 0.5 * (product[i, j] + phi[1, i, j])
    _multiply(phi[0], phi[0], square)
    copy(square, phi[0])


@compiled
def fill_phi(m: Array, phi: Array, square: Array, product: Array) -> None:
    """Fill phi (3, n, n) with phi_0 = exp(m), phi_1 and phi_2 of m (n, n), which is scaled in place."""
    n = m.shape[0]
    norm = 0.0
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += abs(m[i, j])
        norm = max(norm, total)
    doublings, scale = 0, 1.0
    while norm * scale > 1.0 and doublings < 60:
        scale *= 0.5
        doublings += 1
    for i in range(n):
        for j in range(n):
            m[i, j] *= scale
    _small_phi(m, phi, product)
    for _ in range(doublings):
        _double_phi(phi, square, product)


@compiled
def phi_functions(m: Array) -> Array:
    """The three matrices (3, n, n) phi_0 = exp(m), phi_1 and phi_2 of m (n, n), in memory of their own."""
    n = m.shape[0]
    phi, room = np.empty((3, n, n)), np.empty((3, n, n))
    copy(m, room[2])
    fill_phi(room[2], phi, room[0], room[1])
    return phi
