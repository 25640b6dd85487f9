"""What every peer gets: the lab's fused motion, the measured force, and who may see which sample."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from er_model_lab.diagnosis.candidates import baseline
from er_model_lab.fitting.fit import Fit
from er_model_lab.fitting.velocity_channel import on_fused
from er_model_lab.level.damper import opened
from er_model_lab.problem.problem import Problem
from er_model_lab.verbs.load import load
from er_models.model import Model


@dataclass(frozen=True)
class Given:
    """One task of a peer.

    problem: fused motion and measured force; base: the known model, refitted to the training samples; fresh:
    another run of the same damper that only scores.
    """

    problem: Problem
    base: Fit
    fresh: Problem

    @property
    def model(self) -> Model:
        """The refitted base."""
        return self.base.model

    def rms_fresh(self, force: np.ndarray) -> float:
        """Root mean square error [N] of a predicted force (n,) on the fresh run."""
        rows = self.fresh.used
        return float(np.sqrt(np.mean((self.fresh.force - force)[rows] ** 2)))


def given(model: Model, data: Path, fresh: Path) -> Given:
    """The task that two folders of measurements pose; a lag of the velocity is undone for all alike."""
    problem = opened(load(data), model).problem
    base = baseline(on_fused(model), problem).fit
    return Given(problem, base, opened(load(fresh), model).problem)


def everything(problem: Problem) -> Problem:
    """The problem with every sample scored and none fitted."""
    return replace(problem, fold=np.full_like(problem.fold, -1), held_out=problem.used)


@dataclass(frozen=True)
class Answer:
    """What a peer says: names of effects (empty: nothing is missing), error on the fresh run [N], seconds."""

    names: tuple[str, ...]
    rms: float
    seconds: float
