"""Plain SciPy: every effect fitted by `least_squares` beside the model, the smallest BIC wins.

As a user would write it: white residuals, one start per effect (the catalogue's first), training samples only,
all parameters of base and effect free within the catalogue's bounds.
"""

from __future__ import annotations

import numpy as np
from er_model_lab.diagnosis.candidates import missing, starts
from er_model_lab.fitting.fit import Box
from er_models.model import Model
from scipy.optimize import least_squares

from test.peers.data import Answer, Given

MOST = 12
"""Evaluations of Jacobians that one effect is given."""


def fitted(model: Model, task: Given) -> tuple[Model, float]:
    """A model fitted to the training samples, and its BIC."""
    problem, rows = task.problem, task.problem.train
    box = Box(model, problem.forward.free(model), problem.scales)

    def residual(theta: np.ndarray) -> np.ndarray:
        return (problem.force - problem.predict(box.model_at(theta)))[rows]

    inside = np.clip(box.start(), box.low + 1e-9 * box.size, box.high - 1e-9 * box.size)
    found = least_squares(
        residual, inside, bounds=(box.low, box.high), x_scale=box.size, max_nfev=MOST
    )
    n = int(rows.sum())
    bic = n * np.log(2.0 * found.cost / n) + theta_count(box) * np.log(n)
    return box.model_at(found.x), float(bic)


def theta_count(box: Box) -> int:
    """Free parameters."""
    return len(box.free)


def answer(task: Given) -> Answer:
    """The effect with the smallest BIC, or none."""
    best, best_bic = fitted(task.model, task)
    names: tuple[str, ...] = ()
    for effect in missing(task.model, task.problem):
        grown = task.model.with_effect(effect.name, starts(effect, task.problem)[0])
        model, bic = fitted(grown, task)
        if bic < best_bic:
            best, best_bic, names = model, bic, (effect.name,)
    return Answer(names, task.rms_fresh(task.fresh.predict(best)), 0.0)
