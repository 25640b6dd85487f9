"""Wild samples of the force that only show beside a model: what it leaves is smoother than the force itself."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from er_models.model import Array

from er_model_lab.preflight.spikes import spikes
from er_model_lab.problem.problem import Problem


def without_wild(problem: Problem, residual: Array) -> Problem:
    """The problem with no weight on samples that stand alone in what a model leaves (n,) [N], at most a few of them.

    A missing effect acts on neighbours, too, and is never weighed away.
    """
    starts = [int(i) for i in problem.motion.starts]
    alone = np.concatenate([spikes(residual[i:j]) for i, j in pairwise(starts)])
    if problem.wild is not None:
        alone &= ~problem.wild
    n = int(np.sum(alone & problem.used))
    if not n:
        return problem
    said = "1 sample of damper_force stands" if n == 1 else f"{n} samples of damper_force stand"
    note = f"{said} alone beside the model: no weight"
    beside = problem.beside + n
    return replace(problem.without(alone), notes=(*problem.notes, note), beside=beside)
