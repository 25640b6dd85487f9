"""Error of a model on fresh data of the same truth, and the least that can be asked for there."""

from __future__ import annotations

import itertools

import numpy as np
from er_model_lab.fitting.data_reach import beyond
from er_model_lab.level.damper import opened
from er_model_lab.verbs.load import load
from er_models.model import Model

from test.blind.along import force_along
from test.blind.case import Case


def rms(values: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def fresh_errors(case: Case, model: Model) -> dict[str, float | bool]:
    """Root mean square errors [N] on a case that nobody has learnt from.

    model: the model as it is, nothing refitted; truth: the true damper driven by the same fused motion, so
    it suffers the same sensors; noise: of the force channel alone, the measured force less the noiseless one;
    beyond: whether the lab would say that they go beyond what the model was fitted to.
    """
    found = opened(load(case.directory), model)
    problem, left = found.problem, found.given
    order = [int(name.rsplit("_", 1)[1]) - 1 for name in problem.names]
    motion = problem.motion
    channels = np.stack([motion.x, motion.v, motion.a], axis=1)
    parts = [
        force_along(case, record, channels[i:j])
        for record, (i, j) in zip(order, itertools.pairwise(motion.starts), strict=True)
    ]
    clean = [case.clean[record]["damper_force"] for record in order]
    used = problem.used
    further = beyond(model, problem, left)
    return {
        "model": rms(left[used]),
        "truth": rms((problem.force - np.concatenate(parts))[used]),
        "noise": rms((problem.force - np.concatenate(clean))[used]),
        "beyond": further is not None and further.matters,
    }
