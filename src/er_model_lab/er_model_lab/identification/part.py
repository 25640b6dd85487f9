"""Parts of a problem: some rows to learn from, and the records that hold them."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from er_models.prediction import Motion
from numpy.typing import NDArray

from er_model_lab.problem.problem import Problem


def among(problem: Problem, *masks: NDArray[np.bool_]) -> Problem:
    """The problem with only some rows to learn from, wild ones aside."""
    rows = np.logical_or.reduce(masks)
    some = replace(problem, fold=np.where(rows, 0, -1), held_out=np.zeros(rows.size, bool))
    return some.without(problem.wild)


def only(problem: Problem, *masks: NDArray[np.bool_]) -> Problem:
    """As `among`, without the records that hold none of the rows."""
    part = among(problem, *masks)
    motion, kept = records_of(problem.motion, part.train)
    fold, held_out = part.fold[kept], part.held_out[kept]
    return replace(
        part, motion=motion, force=problem.force[kept], fold=fold, held_out=held_out, wild=problem.wild_at(kept)
    )  # fmt: skip


def records_of(motion: Motion, rows: NDArray[np.bool_]) -> tuple[Motion, NDArray[np.int64]]:
    """Motion of the records that hold any of the rows (n,), and the places of its samples in the whole."""
    pairs = [(int(i), int(j)) for i, j in pairwise(motion.starts) if rows[i:j].any()]
    kept = np.concatenate([np.arange(i, j) for i, j in pairs])
    starts = np.concatenate([[0], np.cumsum([j - i for i, j in pairs])])
    m = motion
    cut = Motion(m.dt, m.x[kept], m.v[kept], m.a[kept], m.u[kept], m.theta[kept], starts)
    return cut, kept
