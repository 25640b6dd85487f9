"""What adding an effect gains by chance: in a straight line and cross-validated, for many errors at once.

Everything follows from sums of products over the blocks, which are taken once.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from er_models.model import Array
from numpy.typing import NDArray

from er_model_lab.diagnose.candidates import Candidate, additions
from er_model_lab.diagnose.starts import starts
from er_model_lab.held_out import FOLDS
from er_model_lab.prepare import Problem

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Block:
    """One block left out of a linear fit of many errors.

    size: its samples; inside (p, p), seen (p, s): J^T J and J^T e there; normal (p, p), moment (p, s): the same
    without it; theta (p, s): fit to the rest; square (s,): mean square that it leaves in the block.
    """

    size: int
    inside: Array
    seen: Array
    normal: Array
    moment: Array
    theta: Array
    square: Array


def largest(base: Candidate, rivals: list[Candidate], problem: Problem, errors: Array) -> Array:
    """Largest effect size [N] over all rivals, for each of the errors (n, s).

    A rival is added with all its derivatives where it was fitted, and with its direction from each start.
    """
    train, e = problem.train, errors[problem.train]
    edges = np.searchsorted(problem.fold[train], np.arange(FOLDS + 1))
    j = _scaled(base.fit.jacobian, train)
    blocks = _blocks(j, e, edges)
    best = np.zeros(errors.shape[1])
    for rival in rivals:
        tangent = _blocks(_scaled(rival.fit.jacobian, train), e, edges)
        falls = [_mean([b.square - t.square for b, t in zip(blocks, tangent, strict=True)])]
        effect = base.fit.model.catalogue[rival.name]
        d = _scaled(additions(base, effect, starts(effect, problem), problem), train)
        if d.shape[1]:
            falls += list(_mean(_falls(blocks, j, d, e, edges)))
        best = np.maximum(best, np.sqrt(np.maximum(falls, 0.0)).max(axis=0))
    return best


def _mean(falls: list[Array]) -> Array:
    """Mean over the blocks."""
    return np.asarray(np.mean(falls, axis=0))


def _scaled(columns: Array, train: Mask) -> Array:
    """Columns on the training samples, of unit mean square; those that are nothing are left out."""
    inside = columns[train]
    size = np.sqrt(np.mean(inside**2, axis=0))
    kept = size > 1e-9 * max(float(size.max(initial=0.0)), 1e-300)
    return np.asarray(inside[:, kept] / size[kept])


def _products(a: Array, b: Array, edges: NDArray[np.intp]) -> Array:
    """A^T B over the rows of each block (FOLDS, p, q)."""
    return np.array([a[i:j].T @ b[i:j] for i, j in itertools.pairwise(edges)])


def _blocks(j: Array, errors: Array, edges: NDArray[np.intp]) -> list[Block]:
    """Every block left out once."""
    inside, seen = _products(j, j, edges), _products(j, errors, edges)
    normal, moment = inside.sum(axis=0), seen.sum(axis=0)
    ridge = 1e-10 * np.trace(normal) / max(normal.shape[0], 1) * np.eye(normal.shape[0])
    blocks = []
    for b, (i, k) in enumerate(itertools.pairwise(edges)):
        a, g = normal - inside[b] + ridge, moment - seen[b]
        theta = np.linalg.solve(a, g)
        left = np.sum(errors[i:k] ** 2, axis=0) - np.sum(
            theta * (2.0 * seen[b] - inside[b] @ theta), axis=0
        )
        blocks.append(Block(int(k - i), inside[b], seen[b], a, g, theta, left / (k - i)))
    return blocks


def _falls(
    blocks: list[Block], j: Array, d: Array, errors: Array, edges: NDArray[np.intp]
) -> list[Array]:
    """Fall of the mean square (k, s) in each block when each of the columns d (n, k) is added by itself."""
    crosses, alongs = _products(j, d, edges), _products(d, errors, edges)
    powers = np.array([np.sum(d[i:k] ** 2, axis=0) for i, k in itertools.pairwise(edges)])
    falls = []
    for block, cross, along, power in zip(blocks, crosses, alongs, powers, strict=True):
        rest = crosses.sum(axis=0) - cross
        absorbed = np.linalg.solve(block.normal, rest)
        left = powers.sum(axis=0) - power - np.sum(rest * absorbed, axis=0)
        size = alongs.sum(axis=0) - along - absorbed.T @ block.moment
        amplitude = size / np.maximum(left, 1e-9 * (edges[-1] - block.size))[:, None]
        agreement = along - cross.T @ block.theta
        agreement -= absorbed.T @ (block.seen - block.inside @ block.theta)
        own = power - np.sum(absorbed * (2.0 * cross - block.inside @ absorbed), axis=0)
        falls.append((2.0 * amplitude * agreement - amplitude**2 * own[:, None]) / block.size)
    return falls
