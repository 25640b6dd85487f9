"""What held-out data refuse: effects beside which they are predicted worse than without."""

from __future__ import annotations

from dataclasses import replace

from er_model_lab.diagnosis.candidates import Candidate, finished
from er_model_lab.diagnosis.evidence import shares
from er_model_lab.diagnosis.investigation import judge
from er_model_lab.diagnosis.rule import Rule
from er_model_lab.fitting.velocity_channel import restored
from er_model_lab.level.study import Study
from er_model_lab.problem.problem import Problem
from er_model_lab.residual.errors import errors
from er_model_lab.results.by_record import BAND


def weighed(
    study: Study, rule: Rule, given: Rule, *, later: bool
) -> tuple[Study | None, tuple[str, ...]]:
    """What held-out data leave of a study, None where nothing is left of one after the first, and what to say of it.

    rule: by which it was made; given: by which the first one was.
    """
    study, notes = vetoed(study, rule, 0.0 if later else BAND)
    if not later or not (why := worse(study, given)):
        return study, notes
    other = instead(study, given)
    if other is None:
        return None, (*notes, why)
    return other, (*notes, f"{why}; {other.diagnosis.effects[0]}, tied, does not")


def vetoed(study: Study, rule: Rule, band: float) -> tuple[Study, tuple[str, ...]]:
    """The study without the effects that it found last where held-out data refuse them beside the others, and why.

    band: share by which the error there may rise.
    """
    notes, found = list[str](), study.diagnosis
    taken = [step.taken for step in found.rounds if step.taken is not None]
    while len(found.effects) > 1 and not found.interrupted:
        held, fewer = set(found.effects), len(found.effects) - 1
        before = next((c for c in taken if {*c.effects} < held and len(c.effects) == fewer), None)
        if before is None or not (said := rise(study.problem, before, found.best, band)):
            break
        (last,) = held - {*before.effects}
        notes.append(f"{last} not added: {said}")
        ties = tuple(group for group in found.alternatives if last not in group)
        before = replace(before, fit=restored(before.fit, found.best.fit.model))
        rounds = list(found.rounds)
        found = judge(found.base, before, rounds, found.floor, study.problem, ties, rule)
    return (replace(study, diagnosis=found) if notes else study), tuple(notes)


def worse(study: Study, rule: Rule) -> str:
    """Why a further pass is not taken: what it adds errs more on held-out data than the model without it."""
    found = study.diagnosis
    if not found.effects:
        return ""
    said = rise(study.problem, found.base, found.best, _band(found.explained, rule))
    return f"{' and '.join(found.effects)} not added: {said}" if said else ""


def refused(study: Study, rule: Rule) -> str:
    """Why there is no further pass: held-out data refuse what would begin it, and all that are tied with that."""
    found, problem = study.diagnosis, study.problem
    step = found.further
    if step is None or step.taken is None:
        return ""
    tied = [c for c in step.candidates if c.name in step.ties or c is step.taken]
    _, explained = shares(step.base.mse, step.taken.mse, found.floor)
    said = [rise(problem, step.base, c, _band(explained, rule)) for c in tied]
    if not all(said):
        return ""
    return f"{step.taken.name} not added: {said[tied.index(step.taken)]}"


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
        if rise(problem, found.base, ended, _band(found.explained, rule)):
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
