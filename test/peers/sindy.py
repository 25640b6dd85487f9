"""PySINDy with a library of the catalogue's own terms: sparse regression of what the base model leaves.

Its columns are what each effect adds to the predicted force from each of its starting values, and the base model's
own derivatives, so that the library holds the truth as nearly as a linear one can. STLSQ keeps few; its threshold is
the largest that does almost as well as the best on the last quarter of the training samples, as its users choose it.
The effect whose terms carry most is named.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from er_model_lab.diagnosis.candidates import additions, cross_judged, missing, starts
from er_model_lab.fitting.fit import Box
from er_model_lab.problem.problem import Problem

from test.peers.data import Answer, Given

THRESHOLDS = (0.02, 0.05, 0.1, 0.2, 0.4, 0.8, np.inf)
"""Smallest coefficients that are kept, in units of the residual's standard deviation; the last keeps nothing."""
NEAR = 1.02
"""Share of the smallest error on unseen samples that a sparser model may leave."""


def library(task: Given, problem: Problem) -> tuple[np.ndarray, list[str]]:
    """Terms (n, k) of base and effects along a motion, and the effect each belongs to ('' for the base)."""
    box = Box(task.model, task.base.free, task.problem.scales)
    theta, step = task.base.theta, 1e-4
    here = problem.predict(task.model)
    points = theta + step * np.diag(np.maximum(np.abs(theta), box.size))
    own = (problem.predict_many(task.model, box.vectors(points)) - here).T / step
    columns, names = [own], [""] * own.shape[1]
    left = replace(task.base, residual=problem.force - here)
    at = replace(cross_judged((), task.base, task.problem), fit=left)
    for effect in missing(task.model, task.problem):
        added = additions(at, effect, starts(effect, task.problem), problem)
        columns.append(added)
        names += [effect.name] * added.shape[1]
    return np.hstack(columns), names


def _sparsest(error: Callable[[float], float]) -> float:
    """Largest threshold whose error on unseen samples is within `NEAR` of the smallest."""
    errors = np.array([error(s) for s in THRESHOLDS])
    return max(s for s, e in zip(THRESHOLDS, errors, strict=True) if e <= NEAR * errors.min())


def answer(task: Given) -> Answer:
    """Terms that sparse regression keeps, and the effect among them that carries most."""
    import pysindy

    rows = task.problem.train
    terms, names = library(task, task.problem)
    target = (task.problem.force - task.problem.predict(task.model))[rows]
    size = np.sqrt(np.mean(terms[rows] ** 2, axis=0))
    kept = np.flatnonzero(size > 1e-6 * size.max())
    x, noise = terms[rows][:, kept] / size[kept], float(np.std(target))
    cut = 3 * x.shape[0] // 4

    def regressed(threshold: float, stop: int | None) -> np.ndarray:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            if np.isinf(threshold):
                return np.zeros(x.shape[1])
            found = pysindy.STLSQ(threshold=threshold * noise, alpha=1e-3, normalize_columns=False)
            return found.fit(x[:stop], target[:stop, None]).coef_[0]

    weights = regressed(
        _sparsest(lambda s: np.mean((target[cut:] - x[cut:] @ regressed(s, cut)) ** 2)), None
    )
    carried: dict[str, np.ndarray] = {}
    for place, k in enumerate(kept):
        if names[k] and weights[place] != 0.0:
            carried[names[k]] = carried.get(names[k], 0.0) + weights[place] * x[:, place]
    fresh, _ = library(task, task.fresh)
    force = task.fresh.predict(task.model) + fresh[:, kept] / size[kept] @ weights
    first = (max(carried, key=lambda name: float(np.var(carried[name]))),) if carried else ()
    return Answer(first, task.rms_fresh(force), 0.0)
