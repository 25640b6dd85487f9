r"""Penalised least squares of a term together with the model's parameters, judged on blocks left out.

A model is a straight line about its fit, as in the lab's cross-validation: what it leaves is

.. math::  r = J d + D c + e, \\quad \\min |e|^2 + \\lambda c^T P c

so that a term takes nothing that the parameters can take, and leaving a block out costs one linear solve.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from er_models.model import Array
from numpy.typing import NDArray

RIDGE, DAMPED = 1e-10, 1e-2
"""Weights of every coefficient, over the mean of the diagonal, and of every parameter, over its own: what nothing tells
stays where it is, and a straight line is not believed far from where it was drawn."""
PRESS = 1e4
"""Weight of a condition that is not met, over the mean of the diagonal."""
ROUNDS = 12
"""How often conditions that are not met are looked for."""


@dataclass(frozen=True)
class Normal:
    """Normal equations of blocks: h (b, k, k), g (b, k), squares (b,) of what is explained, samples (b,).

    params: how many of the k columns are the model's parameters, which come first.
    """

    h: Array
    g: Array
    squares: Array
    samples: Array
    params: int

    def through(self, s: Array) -> Normal:
        """The same with the term's coefficients made of fewer ones, c = s z."""
        whole = np.eye(self.params + s.shape[0], self.params + s.shape[1])
        whole[self.params :, self.params :] = s
        return Normal(
            np.einsum("ki,bkl,lj->bij", whole, self.h, whole, optimize=True), self.g @ whole, self.squares,
            self.samples, self.params,
        )  # fmt: skip

    def penalty(self, p: Array, weight: float) -> Array:
        """Penalty (k, k) of the coefficients, of a weight over the size of what the samples say."""
        h = self.h.sum(axis=0)
        own = h[self.params :, self.params :]
        scale = weight * float(np.trace(own)) / max(float(np.trace(p)), 1e-300)
        ridge = np.full(own.shape[0], RIDGE * float(np.trace(own)) / max(own.shape[0], 1))
        told = np.diag(h)[: self.params]
        # of a parameter without effect here, such as one of the field without a duty, nothing is told
        damped = np.where(told > 0.0, DAMPED * told, 1.0)
        out = np.diag(np.concatenate([damped, ridge]))
        out[self.params :, self.params :] += scale * p
        return out

    def alone(self) -> Normal:
        """The same with the parameters where they are."""
        n = self.params
        return Normal(self.h[:, n:, n:], self.g[:, n:], self.squares, self.samples, 0)

    def solved(self, penalty: Array) -> Array:
        """Parameters and coefficients (k,)."""
        return np.asarray(np.linalg.solve(self.h.sum(axis=0) + penalty, self.g.sum(axis=0)))

    def left_out(self, penalty: Array) -> Array:
        """The same without each block and its neighbours (b, k), which are too like it: often one motion again."""
        near = sum(np.eye(len(self.h), k=k) for k in (-1, 0, 1))
        h = self.h.sum(axis=0) - np.einsum("ab,bkl->akl", near, self.h) + penalty
        g = self.g.sum(axis=0) - near @ self.g
        return np.asarray(np.linalg.solve(h, g[:, :, None])[:, :, 0])

    def losses(self, found: Array) -> Array:
        """Mean square (b,) that solutions (b, k) leave of each block."""
        left = self.squares - 2.0 * np.sum(self.g * found, axis=1)
        left += np.einsum("bk,bkl,bl->b", found, self.h, found, optimize=True)
        return np.asarray(left / self.samples)

    def judged(self, penalty: Array) -> Array:
        """Mean square (b,) of each block by what those tell that are no neighbours of it."""
        return self.losses(self.left_out(penalty))

    def mean(self, losses: Array) -> float:
        """Mean square over all samples."""
        return float(np.sum(losses * self.samples) / np.sum(self.samples))

    def pressed(self, penalty: Array, a: Array) -> Array:
        """Penalty with conditions a c >= 0, rows of a (m, coefficients), pressed on where they are not met."""
        own = self.h.sum(axis=0)[self.params :, self.params :]
        size = PRESS * float(np.trace(own)) / own.shape[0]
        rows = a / np.maximum(np.linalg.norm(a, axis=1, keepdims=True), 1e-300)
        out, active = penalty, np.zeros(len(a), bool)
        for _ in range(ROUNDS):
            c = self.solved(out)[self.params :]
            now = active | (rows @ c < 0.0)
            if np.array_equal(now, active):
                break
            active, out = now, penalty.copy()
            out[self.params :, self.params :] += size * rows[active].T @ rows[active]
        return out


def normal(j: Array, d: Array, r: Array, block: NDArray[np.int64]) -> Normal:
    """Normal equations of derivatives j (n, p) by parameters and a design d (n, k), for what is left r (n,).

    block (n,): from 0 on, in order.
    """
    both = np.hstack([j, d])
    edges = np.searchsorted(block, np.arange(int(block.max()) + 2))
    cuts = [slice(a, b) for a, b in itertools.pairwise(edges)]
    return Normal(
        np.array([both[c].T @ both[c] for c in cuts]), np.array([both[c].T @ r[c] for c in cuts]),
        np.array([float(r[c] @ r[c]) for c in cuts]), np.array([float(c.stop - c.start) for c in cuts]), j.shape[1],
    )  # fmt: skip
