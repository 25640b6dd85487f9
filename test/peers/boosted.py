"""Gradient-boosted trees on what the base model leaves: predicts, names nothing.

Features are the lab's own for its noise floor: motion, duty, their recent past and slow quantities.
"""

from __future__ import annotations

from er_model_lab.diagnosis.noise_floor import features
from er_model_lab.problem.problem import Problem
from er_models.model import Model
from sklearn.ensemble import HistGradientBoostingRegressor

from test.peers.data import Answer, Given


def inputs(problem: Problem, model: Model):
    """Features (n, k) along a motion."""
    return features(problem, problem.predict(model))


def answer(task: Given) -> Answer:
    """The base model corrected by trees, which stop where a tenth of the training samples says so."""
    problem, rows = task.problem, task.problem.train
    left = (problem.force - problem.predict(task.model))[rows]
    trees = HistGradientBoostingRegressor(max_iter=400, early_stopping=True, random_state=0)
    trees.fit(inputs(problem, task.model)[rows], left)
    force = task.fresh.predict(task.model) + trees.predict(inputs(task.fresh, task.model))
    return Answer((), task.rms_fresh(force), 0.0)
