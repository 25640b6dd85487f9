"""Error of a model on fresh data, and the least that can be asked for: the truth's, driven by the same fused motion."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from er_model_lab.fitting.data_reach import beyond
from er_model_lab.level.damper import opened
from er_model_lab.preflight.wild import marked
from er_model_lab.verbs.load import load
from er_models.model import Model
from er_records.dataset import Dataset

Along = Callable[[int, np.ndarray, np.ndarray], np.ndarray]
"""The truth's force [N] (n,) of a record, from its times [s] (n,) and deflection, velocity, acceleration (n, 3)."""


def rms(values: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def errors_on(
    folder: Path, model: Model, along: Along, clean: Sequence[tuple[np.ndarray, np.ndarray]]
) -> dict[str, float | bool]:
    """Root mean square errors [N] on the records of a folder, ``record_1`` and so on, that nobody has learnt from.

    model: the model as it is, nothing refitted; truth: the true damper driven by the same fused motion, so
    it suffers the same sensors; noise: of the force channel alone, the measured force less the noiseless one, of
    which clean holds times and force of each record; beyond: whether the lab would say that the data go beyond what
    the model was fitted to.
    """
    data = Dataset.of([marked(record) for record in load(folder).records])
    found = opened(data, model)
    problem, left = found.problem, found.given
    order = [int(name.rsplit("_", 1)[1]) - 1 for name in problem.names]
    motion = problem.motion
    channels = np.stack([motion.x, motion.v, motion.a], axis=1)
    driven, exact = [], []
    for record, (i, j) in zip(order, itertools.pairwise(motion.starts), strict=True):
        t = np.arange(j - i) * motion.dt
        driven.append(along(record, t, channels[i:j]))
        exact.append(np.interp(t, *clean[record]))
    used = problem.used
    further = beyond(model, problem, left)
    return {
        "model": rms(left[used]),
        "truth": rms((problem.force - np.concatenate(driven))[used]),
        "noise": rms((problem.force - np.concatenate(exact))[used]),
        "beyond": further is not None and further.matters,
    }
