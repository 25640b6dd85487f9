"""One candidate: its entry in the contract's JSON, its status, and why it was taken or not."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from er_models.model import Model

from er_model_lab.diagnosis.candidates import Candidate, effect_size
from er_model_lab.diagnosis.decisive_round import told
from er_model_lab.diagnosis.evidence import shares
from er_model_lab.diagnosis.found import Diagnosis
from er_model_lab.diagnosis.search import Round, close, taken_in
from er_model_lab.fitting.deviations import with_deviations
from er_model_lab.level.study import Study
from er_model_lab.problem.problem import Problem
from er_model_lab.residual.errors import errors
from er_model_lab.results.values import parameters

LEAST_KEPT = 0.02
"""Share of an effect's direction [1] that the model must leave it: below, no strength of it would show."""
LEAST_REACH = 0.02
"""Change of the force by an effect, over the noise of the force [1]: below, nothing of it can be seen, or missed."""


def entry(
    candidate: Candidate, step: Round, found: Diagnosis, problem: Problem, after: Model
) -> dict[str, Any]:
    """One entry of `candidates` in the contract's JSON; an effect that was kept has the final model's values.

    After an interruption others have no deviations, which take a tenth of a second each.
    """
    name = candidate.name
    model = candidate.fit.model
    if name in found.effects and name in after.effects:
        model = after
    elif not found.interrupted:
        model = with_deviations(candidate.fit, problem)
    size = effect_size(step.base, candidate)
    status, rivals = _status(candidate, found)
    return {
        "effect": name,
        "rmse_held_out": errors(problem, candidate.fit.residual, problem.held_out).rmse,
        "rmse_before": errors(problem, step.base.fit.residual, problem.held_out).rmse,
        "rmse_cross_validated": float(np.sqrt(candidate.mse)),
        "evidence": size,
        "threshold": step.threshold,
        "p_value": step.null.p_value(size),
        "parameters": parameters(model, name),
        "status": status,
        "confounded_with": rivals,
        "explained_by": _better(candidate, step, found) if size > step.threshold else [],
        "kept_fraction": candidate.kept,
        "explains": shares(step.base.mse, candidate.mse, found.floor)[1],
    }


def _lag_entry(study: Study) -> dict[str, Any]:
    """Entry of the velocity channel's lag, whose evidence is kinematic."""
    assert study.opened.lag is not None
    lag, sd = study.opened.lag
    found, problem = study.diagnosis, study.problem
    return {
        "effect": "velocity_lag",
        "rmse_held_out": errors(problem, found.rounds[0].base.fit.residual, problem.held_out).rmse,
        "rmse_cross_validated": float(np.sqrt(found.rounds[0].base.mse)),
        "evidence": abs(lag) / max(sd, 1e-12),
        "p_value": float(math.erfc(min(abs(lag) / max(sd, 1e-12), 30.0) / math.sqrt(2.0))),
        "parameters": {"T_v": [lag, sd, "s"]},
        "status": "present" if "velocity_lag" in found.effects else "absent",
        "confounded_with": [],
        "basis": "deflection and accelerometers against the velocity channel",
    }


def candidates(study: Study, model_after: Model) -> list[dict[str, Any]]:
    """Entries of all candidates: those that were taken, in their order, then the others by their error."""
    found = study.diagnosis
    lag = [_lag_entry(study)] if study.opened.lag else []
    others = [
        entry(c, step, found, study.problem, model_after)
        for c, step in told(found)
        if not lag or c.name != "velocity_lag"
    ]
    order = {name: i for i, name in enumerate(found.effects)}
    return sorted(
        [*lag, *others],
        key=lambda e: (order.get(e["effect"], len(order)), e["rmse_cross_validated"]),
    )


def _status(candidate: Candidate, found: Diagnosis) -> tuple[str, list[str]]:
    """Status of a candidate, and what it cannot be told from."""
    name = candidate.name
    for group in found.alternatives:
        if name in group:
            return "confounded", [other for other in group if other != name]
    if name in found.effects and (
        found.coverage.blocking or name in (*found.evidence.loose, *found.evidence.slow)
    ):
        return "confounded", _others(candidate, found)
    if name in found.effects:
        return "present", []
    if _absorbed(candidate) or _out_of_reach(candidate):
        return "not_excited", []
    return "absent", []


def _others(candidate: Candidate, found: Diagnosis) -> list[str]:
    """What would do nearly as well as an effect that these data name without certainty."""
    step = taken_in(found.rounds).get(candidate.name)
    return [name for name in close(step) if name != candidate.name] if step else []


def _absorbed(candidate: Candidate) -> bool:
    """Whether the other parameters of the model can make what the effect makes."""
    return candidate.kept < LEAST_KEPT


def _out_of_reach(candidate: Candidate) -> bool:
    """Whether the effect changes next to nothing on these data."""
    return candidate.reach < LEAST_REACH


def _better(candidate: Candidate, step: Round, found: Diagnosis) -> list[str]:
    """What explains the error better than an effect that was not taken; empty for one that was.

    What its round took may have been exchanged since, or taken out.
    """
    if candidate.name in found.effects:
        return []
    taken = step.taken.name if step.taken else None
    return [taken] if taken in found.effects else list(found.effects)


def reason(candidate: Candidate, step: Round, found: Diagnosis) -> str:
    """Why a candidate was taken or not, in one sentence."""
    titles = (
        candidate.fit.model.catalogue[name].title for name in _better(candidate, step, found)
    )
    better, size = " and ".join(titles), effect_size(step.base, candidate)
    if candidate.name in found.effects:
        return f"taken: lowers the error on unseen data by {size:.3g} N, chance reaches {step.threshold:.3g} N"
    if _absorbed(candidate):
        return "these data cannot show it: the model absorbs it completely"
    if _out_of_reach(candidate):
        return "not excited: in these data it would change the force by less than the noise"
    if size <= step.threshold:
        return f"not needed: {max(size, 0.0):.3g} N, chance alone reaches {step.threshold:.3g} N"
    if not better:
        return f"helps by {size:.3g} N, by more than chance, but too little to be named"
    return f"helps by {size:.3g} N, but {better} explains the error better"
