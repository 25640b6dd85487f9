"""What adding an effect gains by chance: in a straight line and cross-validated, for many errors at once.

Everything follows from sums of products over the blocks, which are taken once.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from er_models.model import Array
from numpy.typing import NDArray

from er_model_lab.diagnosis.candidates import Candidate, additions
from er_model_lab.diagnosis.starts import starts
from er_model_lab.fitting.fit import about
from er_model_lab.problem.forward import ROUGH
from er_model_lab.problem.held_out import FOLDS
from er_model_lab.problem.problem import Problem

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Block:
    """A linear fit of many errors to some samples, judged on a block.

    size: samples of the block; fitted: samples of the fit; inside (p, p), seen (p, s): J^T J and J^T e of the block;
    normal (p, p), moment (p, s): the same of the fit; theta (p, s): what it finds; square (s,): mean square that it
    leaves in the block.
    """

    size: int
    fitted: int
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
    blocks = _blocks(_scaled(base.fit.jacobian, train), e, _edges(problem))
    near = about(base.fit, problem, ROUGH).begun(base.fit.model)
    gained = near.each(
        _gained, range(len(rivals)), base, rivals, e, blocks, stage="what chance gives"
    )
    return np.asarray(np.max(gained, axis=0, initial=0.0))


def _gained(
    which: int, problem: Problem, base: Candidate, rivals: list[Candidate], e: Array, blocks: list[Block]
) -> Array:  # fmt: skip
    """Largest effect size (s,) [N] of a rival; e (n, s): errors of the training samples, blocks: without it."""
    train, rival = problem.train, rivals[which]
    edges = _edges(problem)
    tangent = _blocks(_scaled(rival.fit.jacobian, train), e, edges)
    falls = [_counted([b.square - t.square for b, t in zip(blocks, tangent, strict=True)])]
    effect = base.fit.model.catalogue[rival.name]
    d = _scaled(additions(base, effect, starts(effect, problem), problem), train)
    if d.shape[1]:
        j = _scaled(base.fit.jacobian, train)
        falls += list(_counted(_falls(blocks, j, d, e, edges)))
    return np.asarray(np.sqrt(np.maximum(falls, 0.0)).max(axis=0))


def _edges(problem: Problem) -> NDArray[np.intp]:
    """First rows of the blocks among the training samples, and their end."""
    return np.searchsorted(problem.fold[problem.train], np.arange(FOLDS + 1))


def _counted(falls: list[Array]) -> Array:
    """The fall that counts, as in `effect_size`: mean of the blocks left out, no more than the whole fit (first) gains.

    Where one block alone shows a parameter (a gap that is crossed once), nothing else says what it is there.
    """
    return np.minimum(np.mean(falls[1:], axis=0), falls[0])


def _scaled(columns: Array, train: Mask) -> Array:
    """Columns on the training samples, of unit mean square; those that are nothing are left out."""
    inside = columns[train]
    size = np.sqrt(np.mean(inside**2, axis=0))
    kept = size > 1e-9 * max(float(size.max(initial=0.0)), 1e-300)
    return np.asarray(inside[:, kept] / size[kept])


def _products(a: Array, b: Array, edges: NDArray[np.intp]) -> Array:
    """A^T B over the rows of all blocks, then of each (1 + FOLDS, p, q)."""
    each = np.array([a[i:j].T @ b[i:j] for i, j in itertools.pairwise(edges)])
    return np.concatenate([each.sum(axis=0)[None], each])


def _powers(columns: Array, edges: NDArray[np.intp]) -> Array:
    """Sums of squares over the rows of all blocks, then of each (1 + FOLDS, k)."""
    each = np.array([np.sum(columns[i:j] ** 2, axis=0) for i, j in itertools.pairwise(edges)])
    return np.concatenate([each.sum(axis=0)[None], each])


def _fitted(sums: Array) -> Array:
    """Sums over what is fitted: all samples first, then all but each block; sums (1 + FOLDS, ...) as above."""
    return np.concatenate([sums[:1], sums[0] - sums[1:]])


def _blocks(j: Array, errors: Array, edges: NDArray[np.intp]) -> list[Block]:
    """The fit to all samples, judged there, then every block left out once."""
    inside, seen, squares = (
        _products(j, j, edges),
        _products(j, errors, edges),
        _powers(errors, edges),
    )
    sizes = np.concatenate([edges[-1:], np.diff(edges)])
    ridge = 1e-10 * np.trace(inside[0]) / max(j.shape[1], 1) * np.eye(j.shape[1])
    blocks = []
    for b, (a, g) in enumerate(zip(_fitted(inside) + ridge, _fitted(seen), strict=True)):
        theta = np.linalg.solve(a, g)
        left = squares[b] - np.sum(theta * (2.0 * seen[b] - inside[b] @ theta), axis=0)
        fitted = int(_fitted(sizes)[b])
        blocks.append(
            Block(int(sizes[b]), fitted, inside[b], seen[b], a, g, theta, left / sizes[b])
        )
    return blocks


def _falls(
    blocks: list[Block], j: Array, d: Array, errors: Array, edges: NDArray[np.intp]
) -> list[Array]:
    """Fall of the mean square (k, s) in each block when each of the columns d (n, k) is added by itself."""
    crosses, alongs, powers = (
        _products(j, d, edges),
        _products(d, errors, edges),
        _powers(d, edges),
    )
    here = zip(crosses, alongs, powers, strict=True)
    fit = zip(_fitted(crosses), _fitted(alongs), _fitted(powers), strict=True)
    falls = []
    for block, (cross, along, power), (rest, moment, total) in zip(blocks, here, fit, strict=True):
        absorbed = np.linalg.solve(block.normal, rest)
        left = total - np.sum(rest * absorbed, axis=0)
        size = moment - absorbed.T @ block.moment
        amplitude = size / np.maximum(left, 1e-9 * block.fitted)[:, None]
        agreement = along - cross.T @ block.theta
        agreement -= absorbed.T @ (block.seen - block.inside @ block.theta)
        own = power - np.sum(absorbed * (2.0 * cross - block.inside @ absorbed), axis=0)
        falls.append((2.0 * amplitude * agreement - amplitude**2 * own[:, None]) / block.size)
    return falls
