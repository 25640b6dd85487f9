"""Many runs: fits begin on stretches that together cover best what all of them hold.

Only where a fit starts, and which candidates are worth a fit to all, is learnt on them; whatever is compared, judged
or written comes from all runs.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from er_models.predict import Motion
from er_models.scales import Scales
from numpy.typing import NDArray

from er_model_lab.problem.forward import DamperForward
from er_model_lab.problem.stretches import STRETCH, chosen
from er_model_lab.records.record import Record

if TYPE_CHECKING:
    from er_model_lab.problem.prepare import Problem

MANY, PRACTISED = 300.0, 75.0
"""Length of several runs together [s] from which fits begin on stretches of them, and that of these stretches."""


@dataclass(frozen=True)
class Practice:
    """Stretches of the training runs as a problem of their own, and which rows of the whole they are."""

    problem: Problem
    rows: NDArray[np.intp]


@dataclass(frozen=True)
class PartForward(DamperForward):
    """The force along stretches, with bounds and starts in the scales of all runs."""

    whole: Scales

    def scales(self, problem: Problem) -> Scales:
        """Envelope of all runs."""
        del problem
        return self.whole


def practice(problem: Problem, warm_up: float) -> Practice | None:
    """The stretches to practise on; None where the data are short, or one run.

    warm_up: time [s] at the start of each in which unknown states fade.
    """
    motion = problem.motion
    edges = list(itertools.pairwise(motion.starts))
    runs = [(int(i), int(j)) for i, j in edges if problem.train[i:j].any()]
    if motion.n * motion.dt <= MANY or len(runs) < 2 or type(problem.forward) is not DamperForward:
        return None
    budget = round(PRACTISED / motion.dt)
    places = chosen([_as_record(motion, *run) for run in runs], budget, STRETCH[0])
    rows = [np.arange(p.i, p.j) + runs[p.record][0] for p in places]
    return Practice(_stretches(problem, rows, round(warm_up / motion.dt)), np.concatenate(rows))


def _as_record(motion: Motion, i: int, j: int) -> Record:
    """What rows i to j exercise."""
    names = {"deflection": "x", "deflection_velocity": "v", "duty": "u", "temperature": "theta"}
    channels = {name: getattr(motion, short)[i:j] for name, short in names.items()}
    return Record(f"rows {i} to {j}", motion.t[i:j], channels)


def _stretches(problem: Problem, places: list[NDArray[np.intp]], warm_up: int) -> Problem:
    """The problem of stretches laid end to end, the first samples of each left out of the fit."""
    m, rows = problem.motion, np.concatenate(places)
    starts = np.concatenate([[0], np.cumsum([p.size for p in places])])
    signals = {name: getattr(m, name)[rows] for name in ("x", "v", "a", "u", "theta")}
    fold, folds = problem.fold[rows], int(problem.fold.max()) + 1
    for i in starts[:-1]:
        fold[i : i + warm_up] = -1
    inside = np.flatnonzero(fold >= 0)
    fold[inside] = np.arange(inside.size) * folds // inside.size
    return replace(
        problem, motion=replace(m, starts=starts, **signals), force=problem.force[rows], fold=fold,
        held_out=problem.held_out[rows], raw=(), fused=(), forward=PartForward(problem.scales),
        extra=tuple((name, y[rows]) for name, y in problem.extra),
    )  # fmt: skip
