r"""Observers of one structure, affine in the gain Z that a theorem looks for.

.. math::  M = A_{11} - Z A_{12}, \quad J = B_{11} - Z B_{12}

The rest of the law, T, R and S, is fixed by the structure. Thesis (3.45)-(3.49) for the unified
observer; for (4.5) it is M = A - L C, J = L.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from er_models.model import Array

SHARE = 0.85
"""Share of the sprung acceleration's residual that the balance puts down to the yield force at once.

On a rough road all of it is the force, which moves between two samples: without it the NLPV observers leave 4 to 8
times as much (class E). On a smooth one some is the sensor's noise: a share of 1 leaves 1.02 to 1.06 times as much.
"""


class Family(NamedTuple):
    """A11 (N, N), A12 (q, N), B11 (N, m), B12 (q, m), T (N, n), R (n, N), S (n, m)."""

    A11: Array
    A12: Array
    B11: Array
    B12: Array
    T: Array
    R: Array
    S: Array


def luenberger_family(A: Array, C: Array, _D1: Array) -> Family:
    """The observer (4.5): Z is its gain L."""
    n, m = A.shape[0], C.shape[0]
    nothing, one = np.zeros((n, m)), np.eye(n)
    return Family(A, C, nothing, -np.eye(m), one, one, nothing)


def balanced_family(A: Array, C: Array, D1: Array) -> Family:
    """The observer (4.5) that reads its yield force, the last state, from the balance of the sprung mass as well.

    ``f^ = z_f + SHARE (y_1 - C_1 z) / C_1f``: with a share of 1 the estimate makes just the sprung acceleration seen.
    """
    plain = luenberger_family(A, C, D1)
    S = np.zeros_like(plain.S)
    S[-1, 0] = SHARE / C[0, -1]
    return plain._replace(R=plain.R - S @ C, S=S)
