"""Wild samples of the force that only show beside a model: what it leaves is smoother than the force itself."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from er_models.model import Array

from er_model_lab.preflight.bent_ends import far_ends
from er_model_lab.preflight.spikes import Mask, spikes
from er_model_lab.problem.problem import Problem


def without_wild(problem: Problem, residual: Array) -> Problem:
    """The problem with no weight on samples that are wild in what a model leaves (n,) [N], at most a few of them.

    These are ends that a filter has bent and, where the record itself shows wild samples, those that stand alone. A
    missing effect acts on neighbours, too, and elsewhere, and is never weighed away.
    """
    parts = [residual[i:j] for i, j in pairwise(int(i) for i in problem.motion.starts)]
    ends = np.concatenate([far_ends(part) for part in parts])
    found = [(ends, ("is bent at an end", "are bent at an end"))]
    if problem.wild is not None and problem.wild.any():
        alone = np.concatenate([spikes(part) for part in parts])
        found.append((alone & ~ends, ("stands alone", "stand alone")))
    for mask, words in found:
        problem = _without(problem, mask, words)
    return problem


def _without(problem: Problem, mask: Mask, words: tuple[str, str]) -> Problem:
    """The problem with no weight on further samples (n,), and one note of all that are so: what one is, or they are."""
    if problem.wild is not None:
        mask = mask & ~problem.wild
    n = int(np.sum(mask & problem.used))
    if not n:
        return problem
    ends = tuple(f" of damper_force {word} beside the model: no weight" for word in words)
    before = [note for note in problem.notes if note.endswith(ends)]
    total = n + sum(int(note.split()[0]) for note in before)
    note = f"1 sample{ends[0]}" if total == 1 else f"{total} samples{ends[1]}"
    others = (other for other in problem.notes if other not in before)
    return replace(problem.without(mask), notes=(*others, note), beside=problem.beside + n)
