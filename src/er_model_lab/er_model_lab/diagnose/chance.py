"""What adding an effect gains by chance: in a straight line and cross-validated, for many errors at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from er_models.model import Array
from numpy.typing import NDArray

from er_model_lab.diagnose.candidates import Candidate, starts
from er_model_lab.prepare import FOLDS, Problem

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Block:
    """One block left out of a linear fit of many errors.

    rows: its samples; inside (r, p): the model's derivatives there; normal (p, p): J^T J without it; moment
    (p, s): J^T e without it; left (r, s): error there after the fit to the rest.
    """

    rows: Mask
    inside: Array
    normal: Array
    moment: Array
    left: Array


def largest(base: Candidate, rivals: list[Candidate], problem: Problem, errors: Array) -> Array:
    """Largest effect size [N] over all rivals, for each of the errors (n, s).

    A rival is added with all its derivatives where it was fitted, and with its direction from each start.
    """
    j = _scaled(base.fit.jacobian, problem.train)
    blocks = _blocks(j, errors, problem)
    best = np.zeros(errors.shape[1])
    for rival in rivals:
        tangent = _blocks(_scaled(rival.fit.jacobian, problem.train), errors, problem)
        falls = [_mean([_square(b) - _square(t) for b, t in zip(blocks, tangent, strict=True)])]
        d = _scaled(_directions(base, rival, problem), problem.train)
        if d.shape[1]:
            falls += list(_mean([_fall(b, j, d, errors, problem.train) for b in blocks]))
        best = np.maximum(best, np.sqrt(np.maximum(falls, 0.0)).max(axis=0))
    return best


def _mean(falls: list[Array]) -> Array:
    """Mean over the blocks."""
    return np.asarray(np.mean(falls, axis=0))


def _square(block: Block) -> Array:
    """Mean square (s,) that is left in a block."""
    return np.asarray(np.mean(block.left**2, axis=0))


def _directions(base: Candidate, rival: Candidate, problem: Problem) -> Array:
    """What an effect adds to the force (n, k) from each of its starts."""
    model, effect = base.fit.model, base.fit.model.catalogue[rival.name]
    points = starts(effect, problem)
    grown = model.with_effect(effect.name, points[0])
    offset = model.catalogue.offsets[effect.name]
    vectors = np.tile(grown.compiled().p, (len(points), 1))
    for row, point in zip(vectors, points, strict=True):
        row[offset : offset + len(effect.names)] = [point[n] for n in effect.names]
    force = problem.force - base.fit.residual
    return np.nan_to_num(problem.predict_many(grown, vectors) - force).T


def _scaled(columns: Array, train: Mask) -> Array:
    """Columns of unit mean square on the training samples; those that are nothing are left out."""
    size = np.sqrt(np.mean(columns[train] ** 2, axis=0))
    kept = size > 1e-9 * max(float(size.max(initial=0.0)), 1e-300)
    return np.asarray(columns[:, kept] / size[kept])


def _blocks(j: Array, errors: Array, problem: Problem) -> list[Block]:
    """Every block left out once."""
    train = problem.train
    normal, moment = j[train].T @ j[train], j[train].T @ errors[train]
    ridge = 1e-10 * np.trace(normal) / max(normal.shape[0], 1) * np.eye(normal.shape[0])
    blocks = []
    for b in range(FOLDS):
        rows = problem.fold == b
        inside, e = j[rows], errors[rows]
        a, g = normal - inside.T @ inside + ridge, moment - inside.T @ e
        blocks.append(Block(rows, inside, a, g, e - inside @ np.linalg.solve(a, g)))
    return blocks


def _fall(block: Block, j: Array, d: Array, errors: Array, train: Mask) -> Array:
    """Fall of the mean square (k, s) in a block when each of the columns d (n, k) is added by itself."""
    rest, inside = train & ~block.rows, d[block.rows]
    cross = j[rest].T @ d[rest]
    absorbed = np.linalg.solve(block.normal, cross)
    power = np.sum(d[rest] ** 2, axis=0) - np.sum(cross * absorbed, axis=0)
    along = d[rest].T @ errors[rest] - absorbed.T @ block.moment
    amplitude = along / np.maximum(power, 1e-9 * rest.sum())[:, None]
    outside = inside - block.inside @ absorbed
    agreement = outside.T @ block.left
    own = np.sum(outside**2, axis=0)[:, None]
    return np.asarray((2.0 * amplitude * agreement - amplitude**2 * own) / block.rows.sum())
