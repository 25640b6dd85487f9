"""What a diagnosis at the level of the vehicle says beyond that of a damper: its outputs, and what is not knowable."""

from __future__ import annotations

from typing import Any

import numpy as np
from er_models.model import Array

from er_model_lab.diagnosis.study import Study
from er_model_lab.fitting.fit import Fit
from er_model_lab.problem.problem import Problem
from er_model_lab.records.record import CHANNELS
from er_model_lab.vehicle.ride_forward import RideForward

UNKNOWN = 1.0 / 3.0
"""Standard deviation of a change of parameters, all by one share of their values, from which it is not known."""
PART = 0.1
"""Least part of a parameter in such a change, over the largest."""


def ride_json(study: Study) -> dict[str, Any]:
    """Errors of every output, and groups of parameters that the data cannot tell apart; nothing for a damper."""
    found, forward = study.diagnosis, study.problem.forward
    if not isinstance(forward, RideForward):
        return {}
    return {
        "level": "vehicle",
        "channels": channels(study, forward),
        "confounded": confounded(found.best.fit, study.problem),
    }


def channels(study: Study, forward: RideForward) -> dict[str, dict[str, Any]]:
    """Root mean square errors on held-out data of every output, in its own unit."""
    found, n = study.diagnosis, forward.outputs
    held = study.problem.held_out[::n]
    floors = found.floor.each

    def rms(residual: Array, c: int) -> float:
        return float(np.sqrt(np.mean(residual[c::n][held] ** 2)) / forward.weights[c])

    return {
        name: {
            "unit": CHANNELS[name],
            "rmse_as_given": rms(study.given, c),
            "rmse": rms(found.base.fit.residual, c),
            "rmse_after": rms(found.best.fit.residual, c),
            "noise_floor": floors[c].held_out / float(forward.weights[c]),
            "noise": float(forward.noise[c]),
        }
        for c, name in enumerate(forward.names)
    }


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
