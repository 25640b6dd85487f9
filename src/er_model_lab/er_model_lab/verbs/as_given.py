"""A model that ends as it was given, because what it learnt errs more on held-out data."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from er_model_lab.diagnosis.rule import BAND
from er_model_lab.diagnosis.verdict import Verdict
from er_model_lab.level.level import Question
from er_model_lab.level.study import Study
from er_model_lab.residual.errors import errors
from er_model_lab.results.by_record import with_flags
from er_model_lab.results.result import DiagnosisResult, with_notes
from er_model_lab.results.steps import given_left
from er_model_lab.verbs.diagnose import result_of


def ends_worse(first: Study, last: Study) -> str:
    """That the model of the last study errs more on held-out data than the one the first began with, in a sentence.

    Empty where it does not, or by no more than the band that records differ by anyway, or where a lag of the velocity
    channel was found: without it the model given is another one.
    """
    if first.opened.lag or last.opened.lag:
        return ""
    problem = last.problem
    both = given_left(first, problem), last.diagnosis.best.fit.residual
    before, after = (errors(problem, left, problem.held_out).rmse for left in both)
    if not after > (1.0 + BAND) * before:
        return ""
    return (
        f"the model stays as it was given: on held-out data it errs by {before:.3g} N, and by {after:.3g} N with what "
        "the training data teach; they do not show what the held-out data hold"
    )


def as_given(first: Study, asked: Question, why: str) -> DiagnosisResult:
    """The result of `improve` where the model stays as it was given."""
    found = first.diagnosis
    fit = found.base.fit
    fit = replace(
        fit,
        model=first.opened.searched,
        residual=first.opened.given,
        at_bound=np.zeros_like(fit.at_bound),
    )
    kept = replace(found.base, fit=fit, effects=())
    verdict: Verdict = "adequate" if found.verdict == "adequate" else "insufficient_data"
    found = replace(
        found, verdict=verdict, effects=(), alternatives=(), base=kept, best=kept, explained=0.0, further=None,
        reasons=(*(found.reasons if found.verdict == verdict else found.reasons[:1]), why), beside=(),
    )  # fmt: skip
    result = result_of(
        "improve", replace(first, diagnosis=found, checked=None), asked.model, asked
    )
    content = dict(result.view.result) | {"final_verdict": verdict, "measured_terms": []}
    return with_notes(with_flags(replace(result, view=replace(result.view, result=content))), why)
