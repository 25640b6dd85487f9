"""What the level of the vehicle tells beyond that of a damper: errors of every output, and what is not knowable."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from er_models.model import Array
from er_records.record import CHANNELS

from er_model_lab.fitting.fit import Fit
from er_model_lab.level.study import Study
from er_model_lab.motion.white_noise import white_noise
from er_model_lab.problem.problem import Problem

UNKNOWN = 1.0 / 3.0
"""Standard deviation of a change of parameters, all by one share of their values, from which it is not known."""
PART = 0.1
"""Least part of a parameter in such a change, over the largest."""


def after(study: Study) -> dict[str, dict[str, Any]]:
    """Root mean square errors on held-out data of every output, in its own unit."""
    found, problem = study.diagnosis, study.problem
    n = problem.forward.outputs
    held = problem.held_out[::n]

    def rms(residual: Array, c: int, weight: float) -> float:
        return float(np.sqrt(np.mean(residual[c::n][held] ** 2)) / weight)

    return {
        output.name: {
            "unit": CHANNELS[output.name],
            "rmse_as_given": rms(study.opened.given, c, output.weight),
            "rmse": rms(found.base.fit.residual, c, output.weight),
            "rmse_after": rms(found.best.fit.residual, c, output.weight),
            "noise_floor": floor.held_out / output.weight,
            "noise": output.noise,
        }
        for c, (output, floor) in enumerate(
            zip(problem.forward.channels, found.floor.each, strict=True)
        )
    }


def as_given(problem: Problem, left: Array) -> dict[str, dict[str, Any]]:
    """Root mean square error of every output in its own unit, and its share of the signal; left (n,) [N]."""
    n, found = problem.forward.outputs, {}
    used = problem.used[::n]
    for k, output in enumerate(problem.forward.channels):
        error, signal = left[k::n][used], problem.force[k::n][used]
        rmse = float(np.sqrt(np.mean(error**2)))
        found[output.name] = {
            "unit": CHANNELS[output.name], "rmse": rmse / output.weight,
            "relative": rmse / max(float(np.std(signal)), 1e-300),
            "noise": white(problem, left, k) / output.weight,
        }  # fmt: skip
    return found


def white(problem: Problem, left: Array, output: int) -> float:
    """White noise of an output, from what is left of it [N]."""
    part = left[output :: problem.forward.outputs]
    return white_noise([part[i:j] for i, j in pairwise(problem.motion.starts)])


def confounded(fitted: Fit, problem: Problem) -> list[list[str]]:
    """Groups of fitted parameters that only together change what is measured.

    Singular vectors of the derivatives by the logarithm of each parameter: a change by one share of the values
    that the noise hides. A group of one is a parameter that the data do not show.
    """
    inner = np.flatnonzero(~fitted.at_bound & (np.abs(fitted.theta) > 0.0))
    train = problem.train
    j = fitted.jacobian[np.ix_(train, inner)] * fitted.theta[inner]
    noise = float(np.sqrt(fitted.mse(train)))
    _, sizes, directions = np.linalg.svd(j, full_matrices=False)
    groups = []
    for size, direction in zip(sizes, directions, strict=True):
        part = np.abs(direction) / np.abs(direction).max()
        if noise > UNKNOWN * size:
            names = [fitted.free[inner[k]] for k in np.flatnonzero(part > PART)]
            groups.append([f"{effect}.{name}" for effect, name in names])
    return groups
