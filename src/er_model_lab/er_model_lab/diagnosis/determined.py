"""Whether the data determine what an effect was fitted to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from er_models.effect import arguments

from er_model_lab.diagnosis.candidates import Candidate
from er_model_lab.diagnosis.coverage import STEP
from er_model_lab.fitting.deviations import standard_deviations
from er_model_lab.fitting.fit import Fit
from er_model_lab.problem.problem import Problem

CLEAR = 2.0
"""Standard deviations from doing nothing below which the strength of an effect is not determined."""

FAR = 0.5
"""Share of the way from doing nothing to its bound from which on a strength is far: a zero beyond the stroke."""


def far(candidate: Candidate) -> bool:
    """Whether a strength of the effect added last lies in the outer half of its bounds."""
    model, name = candidate.fit.model, candidate.name
    for q in model.catalogue[name].parameters:
        if q.neutral is None:
            continue
        low, high = model.bounds(name, q.name)
        off = model.value(name, q.name) - q.neutral
        if abs(off) > FAR * abs((high if off > 0.0 else low) - q.neutral):
            return True
    return False


def strange(candidate: Candidate) -> bool:
    """Whether a strength of the effect added last is beyond what makes it this effect: a breakaway without friction.

    What it is held against may be in another effect of the model, too.
    """
    model, name = candidate.fit.model, candidate.name
    return any(
        model.value(name, strength) > most * sum(e.get(other, 0.0) for e in model.effects.values())
        for strength, most, other in model.catalogue[name].within
    )


def at_end(candidate: Candidate) -> bool:
    """Whether a value of the effect added last stands at a bound, so that the data do not say how large it is."""
    fitted = candidate.fit
    return any(
        end and place[0] == candidate.name
        for place, end in zip(fitted.free, fitted.at_bound, strict=True)
    )


def unseen(candidate: Candidate, problem: Problem) -> bool:
    """Whether the effect added last is a law of the duty, of which the data hold one value.

    What has a strength beside the duty, too, is none: a friction that the field may raise.
    """
    effect = candidate.fit.model.catalogue[candidate.name]
    of_duty = all("duty" in q.unit for q in effect.parameters if q.neutral is not None)
    follows = of_duty and any({"u", "u_f"} & {*arguments(hook)} for hook in effect.hooks.values())
    still = float(np.ptp(problem.motion.u)) <= STEP
    return still and (follows or effect.stage == "actuation")


def _endless(fitted: Fit) -> set[str]:
    """Effects of which a value of form stands at its upper bound, or at a lower one below zero."""
    found = set[str]()
    for k in np.flatnonzero(fitted.at_bound):
        effect, name = fitted.free[k]
        q = fitted.model.catalogue[effect].parameter(name)
        # a fit ends at a bound but for the last digits
        upper = 2.0 * fitted.theta[k] > q.low + q.high
        if q.neutral is None and not q.optional and (upper or q.low < 0.0):
            found.add(effect)
    return found


def loose(best: Candidate, problem: Problem) -> tuple[str, ...]:
    """Effects of a model whose values the data do not determine.

    A strength stands at a bound other than doing nothing, or none of them is clear of that; or a value of form, which
    is nothing at no value, stands at its upper one, or at a lower one below zero: an elastic way as long as the stroke
    never comes to its end. At a lower one of zero or above it may stand, and refinements at either, and they are taken
    as they are: that friction turns at once, or a void never refills, is an answer.
    """
    if not best.effects:
        return ()
    model, fitted, found = best.fit.model, best.fit, list[str]()
    strength = {
        (name, q.name): q.neutral
        for name in best.effects
        for q in model.catalogue[name].parameters
        if q.neutral is not None and not q.optional
    }
    form = np.array([e in best.effects and (e, p) not in strength for e, p in fitted.free])
    given = replace(fitted, at_bound=fitted.at_bound | form)
    endless, deviations = _endless(fitted), standard_deviations(given, problem)
    for name in best.effects:
        clear, at_end = [], name in endless
        for place, at_bound, sd in zip(fitted.free, fitted.at_bound, deviations, strict=True):
            if place[0] == name and place in strength:
                off = abs(model.value(*place) - strength[place])
                clear.append(off > CLEAR * sd)
                found += [name] if at_bound and off else []
        found += [name] if at_end or (clear and not any(clear)) else []
    return tuple(dict.fromkeys(found))
