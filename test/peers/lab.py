"""The lab itself, asked as any user asks it."""

from __future__ import annotations

from er_model_lab.verbs.ask import Request
from er_model_lab.verbs.improve import improve
from er_models.model import Model

from test.peers.data import Answer, Given


def answer(task: Given, request: Request, out) -> Answer:
    """What `lab improve` names, and the error of its model."""
    outcome = improve(request, out)
    model: Model = outcome.model
    from er_model_lab.diagnosis.study import as_given

    left = as_given(model, task.fresh)
    return Answer(tuple(outcome.result["effects"]), task.rms_fresh(task.fresh.force - left), 0.0)
