"""What held-out data refuse: effects beside which they are predicted worse than without, or as badly."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from er_model_lab.diagnosis.candidates import Candidate, effect_size, finished
from er_model_lab.diagnosis.evidence import shares
from er_model_lab.diagnosis.investigation import judge
from er_model_lab.diagnosis.rule import BAND, Rule
from er_model_lab.diagnosis.search import afresh, decided
from er_model_lab.fitting.fit import mean_square
from er_model_lab.fitting.velocity_channel import restored
from er_model_lab.level.study import Study
from er_model_lab.problem.problem import Problem
from er_model_lab.residual.errors import errors

SEVERAL = 4
"""Effects that held-out data refuse, one after the other, after which no other is tried."""
AS_MUCH, VAIN = 0.25, 0.1
"""Change that an effect makes on held-out data, over that on training data, from which on it acts there as well; and
the share of the gain it promises then below which it is in vain. Both as mean squares."""


def weighed(
    study: Study, rule: Rule, given: Rule, *, later: bool
) -> tuple[Study | None, tuple[str, ...]]:
    """What held-out data leave of a study, None where nothing is left of one after the first, and what to say of it.

    rule: by which it was made; given: by which the first one was. Nothing is fitted for whoever stopped it.
    """
    study, notes = vetoed(study, rule, 0.0 if later else BAND, 1 if later else 0)
    if not later or not (why := worse(study, given)):
        return study, notes
    other = None if study.diagnosis.interrupted else instead(study, given)
    if other is None:
        return None, (*notes, why)
    return other, (*notes, f"{why}; {other.diagnosis.effects[0]}, tied, does not")


def vetoed(study: Study, rule: Rule, band: float, least: int = 0) -> tuple[Study, tuple[str, ...]]:
    """The study without the effects that it found last where held-out data refuse them beside the others, and why.

    band: share by which the error there may rise; least: so many effects stay in any case.
    """
    notes, found = list[str](), study.diagnosis
    taken = [found.base, *(step.taken for step in found.rounds if step.taken is not None)]
    while len(found.effects) > least:
        held, fewer = set(found.effects), len(found.effects) - 1
        before = next((c for c in taken if {*c.effects} < held and len(c.effects) == fewer), None)
        # what promises more than it gives is not worse than nothing
        says = against if fewer else rise
        if before is None or not (said := says(study.problem, before, found.best, band)):
            break
        (last,) = held - {*before.effects}
        notes.append(f"{last} not added: {said}")
        ties = tuple(group for group in found.alternatives if last not in group)
        tried = next((step for step in found.rounds if step.base is before), None)
        before = replace(before, fit=restored(before.fit, found.best.fit.model))
        rounds = list(found.rounds)
        stopped = found.interrupted
        found = judge(found.base, before, rounds, found.floor, study.problem, ties, rule)
        found = replace(found, further=afresh(tried) if tried else None, interrupted=stopped)
    return (replace(study, diagnosis=found) if notes else study), tuple(notes)


def worse(study: Study, rule: Rule) -> str:
    """Why a further pass is not taken: what it adds errs more on held-out data than the model without it."""
    found = study.diagnosis
    if not found.effects:
        return ""
    said = against(study.problem, found.base, found.best, _band(found.explained, rule))
    return f"{' and '.join(found.effects)} not added: {said}" if said else ""


def refused(study: Study, rule: Rule, given: Rule) -> tuple[Rule | None, tuple[str, ...]]:
    """The rule of a further pass, which bars what held-out data refuse to begin it with, and what to say of that.

    None where they refuse several, each with all that are tied with it. rule: of the pass; given: of the first one.
    """
    found, problem, notes = study.diagnosis, study.problem, list[str]()
    step = found.further
    if step is not None and rule.barred:
        step = decided(step.base, step.candidates, step.null, problem, rule)
    while step is not None and step.taken is not None and len(notes) < SEVERAL:
        tied = [c for c in step.candidates if c.name in step.ties or c is step.taken]
        _, explained = shares(step.base.mse, step.taken.mse, found.floor)
        said = [against(problem, step.base, c, _band(explained, given)) for c in tied]
        if not all(said):
            return rule, tuple(notes)
        notes.append(f"{step.taken.name} not added: {said[tied.index(step.taken)]}")
        rule = replace(rule, barred=rule.barred | {c.name for c in tied})
        step = decided(step.base, step.candidates, step.null, problem, rule)
    return (None if notes else rule), tuple(notes)


def instead(study: Study, rule: Rule) -> Study | None:
    """The study with another effect in place of its only one, tied with it, which held-out data do not refuse."""
    found, problem = study.diagnosis, study.problem
    tied = {name for group in found.alternatives for name in group} - {*found.effects}
    if len(found.effects) > 1 or not tied:
        return None
    for c in found.rounds[0].candidates:
        if c.name not in tied:
            continue
        ended = finished(c, problem)
        if against(problem, found.base, ended, _band(found.explained, rule)):
            continue
        ended = replace(ended, fit=restored(ended.fit, found.best.fit.model))
        rounds, ties = list(found.rounds), found.alternatives
        other = judge(found.base, ended, rounds, found.floor, problem, ties, rule)
        return replace(study, diagnosis=other) if other.effects else None
    return None


def _band(explained: float, rule: Rule) -> float:
    """Share by which the error on held-out data may rise in a further pass; a small step must not err more at all."""
    return BAND if explained >= rule.helps else 0.0


def rise(problem: Problem, before: Candidate, after: Candidate, band: float) -> str:
    """By how much the error on held-out data would rise, in a clause; empty where it rises by no more than a share."""
    old, new = (errors(problem, c.fit.residual, problem.held_out).rmse for c in (before, after))
    if new <= (1.0 + band) * old:
        return ""
    return f"the error on held-out data would rise from {old:.3g} N to {new:.3g} N"


def against(problem: Problem, before: Candidate, after: Candidate, band: float) -> str:
    """What held-out data say against an effect, in a clause; empty where they say nothing."""
    return rise(problem, before, after, band) or vain(problem, before, after)


def vain(problem: Problem, before: Candidate, after: Candidate) -> str:
    """That an effect acts on held-out data as on those it was fitted to, and helps only there; empty where it helps.

    It stands for what differs from record to record and is told by each record itself. Of a car all outputs count, as
    in what an effect promises.
    """
    change = (before.fit.residual - after.fit.residual) ** 2
    here, there = (float(np.mean(change[rows])) for rows in (problem.train, problem.held_out))
    old, new = (np.sqrt(mean_square(c.fit.residual[problem.held_out])) for c in (before, after))
    size = effect_size(before, after)
    promised = size**2 * min(there / max(here, 1e-300), 1.0)
    if size <= 0.0 or there < AS_MUCH * here or old**2 - new**2 >= VAIN * promised:
        return ""
    return f"the error on held-out data would stay, {old:.3g} N and {new:.3g} N, though it acts there as well"
