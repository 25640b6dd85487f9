"""Whether the data determine what an effect was fitted to."""

from __future__ import annotations

import numpy as np

from er_model_lab.diagnosis.candidates import Candidate
from er_model_lab.fitting.fit import covariance
from er_model_lab.problem.problem import Problem

CLEAR = 2.0
"""Standard deviations from doing nothing below which the strength of an effect is not determined."""


def loose(best: Candidate, problem: Problem) -> tuple[str, ...]:
    """Effects of a model whose values the data do not determine.

    A strength stands at a bound other than doing nothing, or none of them is clear of that. Values of form, which are
    nothing at no value, may stand at a bound: that a void refills at once is an answer.
    """
    if not best.effects:
        return ()
    model, free = best.fit.model, best.fit.free
    deviations = dict(zip(free, np.sqrt(np.diag(covariance(best.fit, problem))), strict=True))
    at_bound = dict(zip(free, best.fit.at_bound, strict=True))
    found = []
    for name in best.effects:
        clear = []
        for q in model.catalogue[name].parameters:
            place, value = (name, q.name), model.effects[name][q.name]
            if q.neutral is None or place not in deviations:
                continue
            if at_bound[place] and value != q.neutral:
                found.append(name)
            else:
                clear.append(bool(abs(value - q.neutral) > CLEAR * deviations[place]))
        if clear and not any(clear):
            found.append(name)
    return tuple(dict.fromkeys(found))
