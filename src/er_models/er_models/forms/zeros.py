r"""Invariant zeros: motions that an unknown input makes and no output shows.

A zero s with direction (x, w) solves s x = A x + D w, 0 = C x + H w. All of them live in the
largest subspace V that some w keeps inside itself with zero output; on V the system is s -> M, and
its eigenvalues are the zeros. V is found by shrinking: V_0 = everything, V_k+1 = those of V_k that
a w can keep in V_k.

Source: Basile and Marro 1969, weakly unobservable subspace; Trentelman, Stoorvogel and Hautus 2001, 7.3.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import matrix_balance, null_space, orth

from er_models.model import Array

RANK = 1e-9
"""Share of the largest singular value below which one counts as zero, in balanced states."""


def invariant_zeros(A: Array, D: Array, C: Array, H: Array | None = None) -> Array:
    """Zeros [1/s] of x' = A x + D w, y = C x + H w, complex, sorted; empty when there are none.

    A (n, n), D (n, r), C (m, n), H (m, r) or none. Raises `ValueError` where an input acts that
    neither state nor output shows: then every s is a zero.
    """
    A, D, C, H = _balanced(A, D, C, np.zeros((C.shape[0], D.shape[1])) if H is None else H)
    if np.linalg.matrix_rank(np.vstack([D, H]), tol=RANK) < D.shape[1]:
        raise ValueError("two inputs act alike: every s is a zero")
    V = _hidden(A, D, C, H)
    if V.shape[1] == 0:
        return np.zeros(0)
    left = np.block([[V, -D], [np.zeros((H.shape[0], V.shape[1])), -H]])
    if np.linalg.matrix_rank(left, tol=RANK) < left.shape[1]:
        raise ValueError("an input makes a motion that no output shows: every s is a zero")
    moves, *_ = np.linalg.lstsq(left, np.vstack([A @ V, C @ V]))
    return np.asarray(np.sort_complex(np.linalg.eigvals(moves[: V.shape[1]])))


def visibility(A: Array, D: Array, C: Array, H: Array, hertz: Array) -> Array:
    """How clearly motions at frequencies (k,) [Hz] show: smallest over largest singular value of the pencil, (k,).

    It falls to zero towards a zero of the system on the imaginary axis.
    """
    A, D, C, H = _balanced(A, D, C, H)
    n = A.shape[0]
    pencil = np.zeros((len(hertz), n + C.shape[0], n + D.shape[1]), complex)
    pencil[:] = np.block([[-A, -D], [C, H]])
    pencil[:, :n, :n] += 2j * np.pi * np.asarray(hertz)[:, None, None] * np.eye(n)
    pencil = pencil / np.abs(pencil).max(axis=2, keepdims=True)
    values = np.linalg.svd(pencil, compute_uv=False)
    return np.asarray(values[:, -1] / values[:, 0])


def _balanced(A: Array, D: Array, C: Array, H: Array) -> tuple[Array, Array, Array, Array]:
    """The same system with states, inputs and outputs of comparable size."""
    balanced, (scale, _) = matrix_balance(A, permute=False, separate=True)
    D, C = D / scale[:, None], C * scale
    columns = np.abs(np.vstack([D, H])).max(axis=0)
    D, H = D / np.where(columns > 0.0, columns, 1.0), H / np.where(columns > 0.0, columns, 1.0)
    rows = np.abs(np.column_stack([C, H])).max(axis=1, keepdims=True)
    rows = np.where(rows > 0.0, rows, 1.0)
    return balanced, D, C / rows, H / rows


def _hidden(A: Array, D: Array, C: Array, H: Array) -> Array:
    """Basis (n, k) of the largest subspace that stays inside itself without an output."""
    n, V = A.shape[0], np.eye(A.shape[0])
    while True:
        outside = null_space(V.T, rcond=RANK).T if V.shape[1] < n else np.zeros((0, n))
        rows = np.block([[outside @ A @ V, outside @ D], [C @ V, H]])
        kept = V @ _null(rows)[: V.shape[1]]
        smaller = orth(kept, rcond=RANK) if kept.size else np.zeros((n, 0))
        if smaller.shape[1] == V.shape[1]:
            return V
        V = smaller


def _null(rows: Array) -> Array:
    """Null space of rows of any size, each row scaled to one; rows of zeros do not count."""
    sizes = np.abs(rows).max(axis=1, keepdims=True, initial=0.0)
    kept = rows[sizes[:, 0] > RANK * max(1.0, float(sizes.max(initial=0.0)))]
    if not kept.size:
        return np.eye(rows.shape[1])
    kept = kept / np.abs(kept).max(axis=1, keepdims=True)
    return np.asarray(null_space(kept, rcond=RANK))
