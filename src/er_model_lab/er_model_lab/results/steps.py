"""The errors of a study's models, and their fall, step by step."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from er_models.model import Array

from er_model_lab.diagnosis.candidates import Candidate, effect_size
from er_model_lab.diagnosis.decisive_round import spoken
from er_model_lab.diagnosis.search import Round
from er_model_lab.fitting.fit import Fit
from er_model_lab.fitting.velocity_channel import as_searched
from er_model_lab.level.study import Study
from er_model_lab.problem.problem import Problem
from er_model_lab.residual.errors import errors


def left_of(study: Study, fitted: Fit, on: Problem | None) -> Array:
    """What a model of a study leaves (n,) [N]: of its own data, or of those of another problem."""
    if on is None or on is study.problem:
        return fitted.residual
    return np.asarray(on.force - on.predict(as_searched(fitted)))


def given_left(study: Study, on: Problem | None) -> Array:
    """What the model as it was given leaves (n,) [N]: of the study's own data, or of those of another problem."""
    if on is None or on is study.problem:
        return study.opened.given
    return np.asarray(on.force - on.predict(study.opened.searched))


def errors_of(study: Study, on: Problem | None = None) -> dict[str, Any]:
    """Errors of the model as given, refitted and after, on both kinds of data, and the floors under them [N].

    on: the problem of a later pass with other data, where the errors are to be those of its data.
    """
    found, problem = study.diagnosis, on or study.problem
    given = given_left(study, on)
    left = [left_of(study, fitted.fit, on) for fitted in (found.base, found.best)]
    rows = {"train": problem.train, "held_out": problem.held_out}
    base, after = ({name: errors(problem, r, mask) for name, mask in rows.items()} for r in left)
    return {
        "noise_floor": found.floor.first.held_out,
        "noise_floor_train": found.floor.first.floor,
        "rmse": {name: e.rmse for name, e in base.items()},
        "nrmse": {name: e.nrmse for name, e in base.items()},
        "rmse_as_given": errors(problem, given, problem.held_out).rmse,
        "rmse_as_given_train": errors(problem, given, problem.train).rmse,
        "rmse_after": {name: e.rmse for name, e in after.items()},
    }


def steps(study: Study, on: Problem | None = None) -> list[dict[str, Any]]:
    """The falling error, one entry per effect taken, with the evidence for it.

    on: where a later pass had other data, its problem; the errors are of its data then.
    """
    problem, found = study.problem, study.diagnosis

    def entry(added: str | None, candidate: Candidate) -> dict[str, Any]:
        judge, left = on or problem, left_of(study, candidate.fit, on)
        train, held = (errors(judge, left, mask).rmse for mask in (judge.train, judge.held_out))
        return {"added": added, "rmse_train": train, "rmse_held_out": held}

    base = study.before or found.rounds[0].base
    out: list[dict[str, Any]] = [entry(None, base)]
    if study.opened.lag:
        out.append(entry("velocity_lag", found.rounds[0].base))
    named = {s["added"] for s in out}

    def rest(candidate: Candidate) -> None:
        """Name the effects of a candidate that no entry names yet: no round took them as they are now."""
        left = [e for e in candidate.effects if e not in named]
        if left:
            step = spoken(left[0], found) if len(left) == 1 else None
            told = _evidence(step, step.taken, problem) if step and step.taken else {}
            out.append(entry(" + ".join(left), candidate) | told)
            named.update(left)

    for step in found.rounds:
        taken = step.taken
        if taken is not None and set(taken.effects) <= set(found.effects):
            rest(step.base)
            out.append(entry(taken.name, taken) | _evidence(step, taken, problem))
            named.add(taken.name)
    rest(replace(found.best, effects=found.effects))
    tried = found.rounds[0].candidates
    if len(out) == 1 and len(tried) == 1:
        # one effect was asked for: it is in the model, whether it helps or not
        out.append(entry(tried[0].name, tried[0]))
    return out


def _evidence(step: Round, taken: Candidate, problem: Problem) -> dict[str, float]:
    """Effect size and its threshold [N], and the shares of blocks left out and of records whose error fell."""
    base, used = step.base, problem.used
    starts = problem.motion.starts * problem.forward.outputs
    runs = [slice(int(i), int(j)) for i, j in pairwise(starts) if used[i:j].any()]
    falls = used * (base.fit.residual**2 - taken.fit.residual**2)
    return {
        "evidence": float(effect_size(base, taken)),
        "threshold": float(step.threshold),
        "blocks": float(np.mean(base.losses > taken.losses)),
        "records": float(np.mean([falls[run].sum() > 0.0 for run in runs])),
    }
