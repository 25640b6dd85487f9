"""The lab itself, asked as any user asks it."""

from __future__ import annotations

from pathlib import Path

from er_model_lab.fitting.velocity_channel import on_fused
from er_model_lab.verbs.improve import improve
from er_model_lab.verbs.load import load
from er_models.model import Model

from test.peers.data import Answer, Given


def answer(task: Given, data: Path, model: Model, seed: int) -> Answer:
    """What `lab improve` names, and the error of its model."""
    result = improve(load(data), model, seed=seed)
    force = task.fresh.predict(on_fused(result.model))
    return Answer(result.effects, task.rms_fresh(force), 0.0)
