"""How large an effect appears by chance when the model is complete.

The current model is taken as the truth: its motion gets the noise of every sensor, is fused again, and
the force gets noise of the size and colour that the best model leaves. The largest effect size over
the whole catalogue is recorded (Westfall and Young 1993), so that asking thirty questions costs nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from er_models.model import Array

from er_model_lab.diagnose.candidates import Candidate
from er_model_lab.prepare import FOLDS, Problem, white_noise


@dataclass(frozen=True)
class Null:
    """Largest effect sizes [N] by chance, one per replicate.

    input_error: force error [N] that the motion sensors cause on the training samples, and on the held-out ones;
    force_noise [N] with its lag-one correlation `colour`.
    """

    maxima: Array
    input_error: float
    input_error_held_out: float
    force_noise: float
    colour: float

    def threshold(self, level: float = 0.05, factor: float = 1.3) -> float:
        """Effect size that chance passes with this probability, with a safety factor [N]."""
        return factor * float(np.quantile(self.maxima, 1.0 - level)) if self.maxima.size else 0.0

    def p_value(self, size: float) -> float:
        """Share of complete models in which chance alone does as well, never below 1 / (replicates + 1)."""
        return float((1 + np.sum(self.maxima >= size)) / (self.maxima.size + 1))


def simulate_null(
    base: Candidate, rivals: list[Candidate], problem: Problem, seed: int, replicates: int = 16
) -> Null:
    """Replicates of `problem` under the fitted model, scored for every rival by one linear step."""
    rng = np.random.default_rng(seed)
    wobble = problem.forward.input_errors(problem, base.fit.model, rng, replicates)
    input_error = float(np.sqrt(np.mean(wobble[:, problem.train] ** 2)))
    held_out = float(np.sqrt(np.mean(wobble[:, problem.held_out] ** 2)))
    leader = rivals[0] if rivals else base
    noise, colour = _force_noise(leader, problem, input_error)
    errors = wobble + problem.forward.output_errors(
        leader.fit.residual, noise, colour, rng, replicates
    )
    start = _linear_losses(base.fit.jacobian, errors, problem)
    best = np.zeros(replicates)
    for rival in rivals:
        gain = start - _linear_losses(rival.fit.jacobian, errors, problem)
        best = np.maximum(best, np.sqrt(np.maximum(gain, 0.0)))
    return Null(best, input_error, held_out, noise, colour)


def _force_noise(best: Candidate, problem: Problem, input_error: float) -> tuple[float, float]:
    """Size [N] and lag-one correlation of the force noise, from what the best rival leaves."""
    r = best.fit.residual[problem.train]
    left = float(np.mean(r**2)) - input_error**2
    size = float(np.sqrt(max(left, white_noise([r]) ** 2, 1e-24)))
    colour = float(np.clip(np.mean(r[1:] * r[:-1]) / max(float(np.mean(r**2)), 1e-300), 0.0, 0.9))
    return size, min(colour, 0.5)


def _linear_losses(jacobian: Array, errors: Array, problem: Problem) -> Array:
    """Cross-validated mean squares (replicates,) of error series after a linear fit on all columns."""
    train = problem.train
    size = np.sqrt(np.mean(jacobian[train] ** 2, axis=0))
    j = jacobian[:, size > 1e-12 * max(float(size.max(initial=0.0)), 1e-300)]
    j = j / np.sqrt(np.mean(j[train] ** 2, axis=0))
    h = j[train].T @ j[train]
    g = j[train].T @ errors[:, train].T
    ridge = 1e-9 * np.trace(h) / max(h.shape[0], 1) * np.eye(h.shape[0])
    total = np.zeros(errors.shape[0])
    for b in range(FOLDS):
        rows = problem.fold == b
        jb, eb = j[rows], errors[:, rows].T
        theta = np.linalg.solve(h - jb.T @ jb + ridge, g - jb.T @ eb)
        total += np.sum((eb - jb @ theta) ** 2, axis=0)
    return np.asarray(total / train.sum())
