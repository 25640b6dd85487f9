"""Diagnose and add, again and again, until the model is adequate or nothing known helps."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from er_models.errors import InputError
from er_models.model import Array, Model
from er_records.dataset import Dataset

from er_model_lab.blas import on_one_thread
from er_model_lab.diagnosis.candidates import Candidate
from er_model_lab.diagnosis.decisive_round import beside
from er_model_lab.diagnosis.exchange import Exchange, exchanged_late
from er_model_lab.diagnosis.floor_estimates import AGREE
from er_model_lab.diagnosis.found import Diagnosis
from er_model_lab.diagnosis.investigation import BEYOND_DOUBT
from er_model_lab.diagnosis.rule import BAND, RULE, Rule
from er_model_lab.diagnosis.search import prune
from er_model_lab.fitting.velocity_channel import as_searched, restored
from er_model_lab.level.investigate import investigate
from er_model_lab.level.level import Question
from er_model_lab.level.study import Study, checked, summary
from er_model_lab.residual.errors import regions_json, worst
from er_model_lab.results.by_record import by_record, with_flags
from er_model_lab.results.diagnosis import diagnosis_json
from er_model_lab.results.draw import candidate_views, study_regions, views
from er_model_lab.results.passes import explained_by, of_the_last, taken_last, told_together
from er_model_lab.results.result import DiagnosisResult, with_notes
from er_model_lab.results.steps import errors_of, left_of, steps
from er_model_lab.results.terms import as_study, with_term
from er_model_lab.results.values import clean, headline
from er_model_lab.terms.learn import MOST_TERMS, Learnt, learn
from er_model_lab.verbs.as_given import as_given, ends_worse
from er_model_lab.verbs.asking import question
from er_model_lab.verbs.diagnose import offer, result_of
from er_model_lab.verbs.history import with_history
from er_model_lab.verbs.resume import Begun, begun, finished, left_by, marked, resume, with_fits
from er_model_lab.verbs.veto import SEVERAL, refused, rise, weighed
from er_model_lab.view import View
from er_model_lab.work import STOPPED, Event, Leader, Progress, Work

Keep = Callable[[Model], None]
"""Takes what an interruption would leave."""

MOST_PASSES = 7
"""How often the model that was just improved is diagnosed."""
FURTHER = 0.05
"""Share of what is explainable that an effect must explain once others have explained a part: a small step."""
KEEP_EVERY = 30.0
"""Time from one keeping of what was done to the next [s]."""


@on_one_thread
def improve(
    data: Dataset,
    model: Model,
    *,
    name: str | None = None,
    interrupted: Model | None = None,
    held_out: Dataset | None = None,
    level: str = "damper",
    seed: int = 0,
    rule: Rule = RULE,
    anyway: bool = False,
    progress: Progress | None = None,
    cancel: Event | None = None,
    executor: Executor | None = None,
    keep: Keep | None = None,
    measured_terms: bool = False,
) -> DiagnosisResult:
    """Diagnose and add until the model is adequate or nothing known helps; the new model is refitted in any case.

    measured_terms: what is left then is learnt as a smooth term or two, measured and not explained, where they help.

    Ctrl-C ends it with what was done until then. From the model of that result, given as `interrupted`, the same call
    goes on to the same end. name: of the new model. keep: is called every half minute with such a model, so that
    what was done outlives the process.
    """
    asked = question(
        data,
        model,
        held_out=held_out,
        level=level,
        seed=seed,
        rule=replace(rule, goes_on=True),
        anyway=anyway,
        work=Work.by(executor, progress, cancel),
    )
    if measured_terms and asked.level.name != "damper":
        raise InputError("level", "", "damper (measured terms add to the damper force)", level)
    start = resume(interrupted, model, asked.data)
    named = name or f"{model.name}_improved"
    made = _together(_passes(asked, start, named, keep), asked, start, named)
    if measured_terms and not made.stopped:
        made = _with_terms(made, asked, start, named)
    last = made.terms[-1][1] if made.terms else made.studies[-1]
    why = "" if made.stopped else ends_worse(made.studies[0], last)
    made = (
        replace(made, model=asked.model, last=None)
        if why
        else _estimated(made, asked, start, named)
    )
    current = finished(made.model, interrupted=made.stopped)
    told = as_given(made.studies[0], asked, why) if why else _improved(made, current, asked)
    result = with_notes(gone_on(told, start), *made.notes)
    result = result if measured_terms else with_notes(result, last=offer(result, asked))
    content = dict(result.view.result) | {"interrupted": made.stopped}
    kept = with_fits(current, start.noted) if made.stopped else current
    return replace(
        result, view=replace(result.view, result=content), model=kept, interrupted=made.stopped
    )


@dataclass(frozen=True)
class _Passes:
    """Studies one after another, the model that they made, whether Ctrl-C ended them, and what else there is to say.

    last: the study that made the model, and the model before it; None where none did, or where the model holds its
    estimates already. dropped: effects that were added and are not needed beside those added later, each with what came
    in its place; terms: what was learnt at last, each with its study and the size it had to exceed [N].
    """

    studies: list[Study]
    model: Model
    last: tuple[Study, Model] | None = None
    stopped: bool = False
    notes: tuple[str, ...] = ()
    dropped: Mapping[str, Sequence[str]] = field(default_factory=dict)
    terms: tuple[tuple[Learnt, Study, float], ...] = ()


def _passes(asked: Question, start: Begun, name: str, keep: Keep | None) -> _Passes:
    """One study after another; none after the first is taken whose model errs more on held-out data.

    Where known effects explain a part only, many forms fit nearly: later studies go on in small steps.
    """
    current, studies, given = asked.model, list[Study](), asked.rule
    made: tuple[Study, Model] | None = None
    notes, tries = tuple[str, ...](), 0
    while len(studies) < MOST_PASSES and tries < SEVERAL:
        left = current if studies else begun(current, asked.data, start)
        work = _keeping(asked.work, left, start, keep)
        last = studies[-1] if studies else None
        if last is not None:
            rule, said = refused(last, asked.rule, given)
            notes = (*notes, *said)
            if rule is None:
                return _Passes(studies, current, made, notes=notes)
            asked = replace(asked, rule=rule)
        now = replace(
            asked,
            model=current,
            seed=asked.seed + 1000 * (len(studies) + tries),
            work=work,
            last=last,
        )
        try:
            seen = investigate(now, start.noted)
            study, said = weighed(seen, asked.rule, given, later=bool(studies))
        except STOPPED:
            asked.work.wind_up()
            if not studies:
                if keep is not None and start.noted:
                    keep(left_by(left, start))
                raise
            return _Passes(studies, current, made, stopped=True, notes=notes)
        notes = (*notes, *said)
        if study is None and seen.diagnosis.interrupted:
            return _Passes(studies, current, made, stopped=True, notes=notes)
        if study is None:
            # what held-out data refuse may hide another effect, which they do not
            barred = asked.rule.barred | {*seen.diagnosis.effects}
            asked, tries = replace(asked, rule=replace(asked.rule, barred=barred)), tries + 1
            continue
        if studies:
            studies[-1] = summary(studies[-1])
        studies.append(study)
        # of long data with the stretches where the model did worst
        asked = replace(asked, data=study.data)
        found = study.diagnosis
        refitted = current is asked.model and (
            found.verdict != "insufficient_data" or not found.coverage.blocking
        )
        if found.effects or refitted:
            made = (study, current)
            current = _grown(_as_fitted(study), made, asked, start, name)
        if found.interrupted or not _goes_on(found):
            return _Passes(studies, current, made, stopped=found.interrupted, notes=notes)
        asked, tries = replace(asked, rule=_after(seen.diagnosis, found, asked.rule, given)), 0
    return _Passes(studies, current, made, notes=notes)


def _after(seen: Diagnosis, kept: Diagnosis, rule: Rule, given: Rule) -> Rule:
    """The rule of the pass after one that found this, of which held-out data kept that: in small steps after a part.

    It does not begin with what they have just refused. rule: of the pass; given: of the first one.
    """
    barred = given.barred | ({*seen.effects} - {*kept.effects})
    if kept.verdict != "partial":
        return replace(rule, barred=barred)
    return replace(given, helps=min(given.helps, FURTHER), small_steps=True, barred=barred)


def _as_fitted(study: Study) -> Study:
    """The study as one that nobody waits for: its model gets its deviations, but no estimates, which take long."""
    return replace(study, diagnosis=replace(study.diagnosis, interrupted=True))


def _grown(
    study: Study, made: tuple[Study, Model], asked: Question, start: Begun, name: str
) -> Model:
    """The model of a study with its history; made: the study to tell of, and the model before it."""
    best = asked.level.finished(study, asked.seed)
    return marked(with_history(best, made[1], made[0], asked.seed, name), start.digest)


def _estimated(made: _Passes, asked: Question, start: Begun, name: str) -> _Passes:
    """The passes with the estimates of their model, which no pass needs before the last."""
    if made.last is None or made.stopped:
        return made
    asked.work.report("estimating values", 0, 1)
    try:
        model = _grown(made.last[0], made.last, asked, start, name)
    except STOPPED:
        asked.work.wind_up()
        return replace(made, stopped=True)
    return replace(made, model=model)


def _goes_on(found: Diagnosis) -> bool:
    """Whether a further study may add something: a part is explained, or all of it with more than noise left."""
    if found.verdict != "missing_effect":
        return found.verdict == "partial"
    return float(np.sqrt(found.best.mse)) > AGREE * found.floor.floor


def _together(made: _Passes, asked: Question, start: Begun, name: str) -> _Passes:
    """What several studies made, seen as a whole: effects are exchanged for what came near them, and left out.

    What goes is what leaves more beside those added later, what is needless there, and what cancels. Errors of the
    velocity channel that were undone before are no part of what is searched.
    """
    added = tuple(e for e in made.model.effects if e not in asked.model.effects)
    if len(made.studies) < 2 or len(added) < 2 or made.stopped:
        return made
    last = made.studies[-1]
    found, problem = last.diagnosis, last.problem
    bare, limit = _as_searched(found.best), found.rounds[0].threshold
    able = tuple(e for e in bare.fit.model.effects if e in added)
    rounds = [step for study in made.studies for step in study.diagnosis.rounds]
    try:
        other, exchanges = exchanged_late(replace(bare, effects=able), rounds, problem, limit)
        kept = prune(other, problem, BEYOND_DOUBT * limit)
    except STOPPED:
        asked.work.wind_up()
        return replace(made, stopped=True)
    if rise(problem, found.best, kept, BAND):
        kept = other
    gone = [e for e in able if e not in kept.effects]
    if not gone:
        return made
    dropped = {e: [come for name, come in exchanges if name == e] for e in gone}
    kept = replace(kept, fit=restored(kept.fit, found.best.fit.model))
    come = tuple(e for e in kept.effects if e not in able)
    own = (*(e for e in found.effects if e in kept.effects), *come)
    left = replace(found, best=replace(kept, effects=own), effects=own)
    if come:
        left = replace(left, beside=beside(left, problem))
    study = replace(last, diagnosis=left)
    grown = (study, made.model)
    return replace(
        made,
        studies=[*made.studies[:-1], study],
        model=_grown(_as_fitted(study), grown, asked, start, name),
        last=grown,
        dropped=dropped,
        notes=(*made.notes, *_said(exchanges, other, kept)),
    )


def _said(exchanges: Sequence[Exchange], other: Candidate, kept: Candidate) -> Iterator[str]:
    """What is said of effects that were exchanged, and of those that were left out then."""
    for gone, come in exchanges:
        yield f"{come} in the place of {gone}: beside the other effects the error is smaller so"
    less = [e for e in other.effects if e not in kept.effects]
    if less:
        yield f"{' and '.join(less)} taken out again: beside the other effects the error stays the same without"


def _as_searched(best: Candidate) -> Candidate:
    """A candidate with its model as it was fitted: without what was undone before."""
    return replace(best, fit=replace(best.fit, model=as_searched(best.fit)))


def _with_terms(made: _Passes, asked: Question, start: Begun, name: str) -> _Passes:
    """The passes with what they leave learnt as measured terms, one after the other, or a note why there is none."""
    if made.studies[-1].diagnosis.verdict in ("adequate", "insufficient_data"):
        return replace(made, notes=(*made.notes, "nothing is left to learn as a measured term"))
    many = -1
    while many < len(made.terms) < MOST_TERMS and not made.stopped:
        many = len(made.terms)
        made = _with_term(made, asked, start, name)
    return made


def _with_term(made: _Passes, asked: Question, start: Begun, name: str) -> _Passes:
    """The same with one term more; where it is the first, else a note why there is none."""
    study = made.terms[-1][1] if made.terms else made.studies[-1]
    best, limit = study.diagnosis.best, made.studies[-1].diagnosis.rounds[-1].threshold
    bare, problem = _as_searched(best), replace(study.problem, work=asked.work)
    asked.work.report("learning what is left", 0, 1)
    try:
        found = learn(bare, problem, limit)
    except STOPPED:
        asked.work.wind_up()
        return replace(made, stopped=True)
    if isinstance(found, str):
        return made if made.terms else replace(made, notes=(*made.notes, found))
    candidate = replace(found.candidate, fit=restored(found.candidate.fit, best.fit.model))
    grown = checked(as_study(study, replace(found, candidate=candidate)))
    model = with_history(
        asked.level.finished(grown, asked.seed), made.model, grown, asked.seed, name
    )
    terms = (*made.terms, (found, grown, limit))
    return replace(made, model=marked(model, start.digest), last=None, terms=terms)


def _keeping(work: Work, left: Model, start: Begun, keep: Keep | None) -> Work:
    """The same work, which keeps what was done every now and then; left: the model so far."""
    if keep is None:
        return work
    last = time.monotonic()

    def told(stage: str, done: int, total: int, best: tuple[Leader, ...]) -> None:
        nonlocal last
        if start.noted and time.monotonic() - last > KEEP_EVERY:
            keep(left_by(left, start))
            last = time.monotonic()
        if work.progress is not None:
            work.progress(stage, done, total, best)

    return work.reporting(told)


def _improved(made: _Passes, model: Model, asked: Question) -> DiagnosisResult:
    """The result of several passes as one fall of the error."""
    studies = [_as_fitted(s) for s in made.studies] if made.stopped else made.studies
    first, last = studies[0], studies[-1]
    result = result_of("improve", first, model, asked)
    results = [dict(result.view.result)]
    results += [_later(s, model, asked, straight=_told_later(s, last)) for s in studies[1:]]
    if not _same_data(first, last):
        # one fall is told on one data set: that of the last pass
        for content, study in zip(results[:-1], studies[:-1], strict=True):
            content |= clean(
                {**errors_of(study, last.problem), "steps": steps(study, last.problem)}
            )
    cards = [result.view.candidates]
    cards += [candidate_views(s, r) for s, r in zip(studies[1:], results[1:], strict=True)]
    whole = told_together(results, last.diagnosis.evidence, asked.rule, made.dropped)
    whole["notes"] = of_the_last(whole["notes"], results[-1]["notes"])
    notes = tuple(of_the_last(result.view.notes, results[-1]["notes"]))
    view = replace(result.view, candidates=taken_last(cards, results), notes=notes)
    if len(studies) > 1:
        whole |= explained_by(first.diagnosis, last.diagnosis)
    if first.checked is not None and last.checked is not None:
        told, now = (s.checked.note(again=s.again) for s in (first, last) if s.checked)
        whole["notes"] = [now if note == told else note for note in whole["notes"]]
        view = replace(view, notes=tuple(now if note == told else note for note in view.notes))
    whole["measured_terms"] = list[Any]()
    for found, last, limit in made.terms:
        whole = with_term(whole, found, last, first, limit)
        view = replace(view, notes=(whole["notes"][0], *view.notes))
    if last is not first:
        view, tables = _drawn_on_last(view, first, last, asked.seed)
        whole |= tables
        view = replace(view, headline=headline(whole["rmse"]["held_out"], whole["noise_floor"]))
    return with_flags(replace(result, view=replace(view, result=whole), model=model))


def _drawn_on_last(
    view: View, first: Study, last: Study, seed: int
) -> tuple[View, dict[str, Any]]:
    """Pictures and regions of the models before and after all passes, both on the data of the last one."""
    problem, before = last.problem, _before(first, last)
    after = problem.force - last.diagnosis.best.fit.residual
    both = study_regions(last, seed, *(problem.force - force for force in (before, after)))
    drawn = replace(
        view, records=views(problem, before, after), regions=both[0], regions_after=both[1]
    )
    tables = {
        "regions": regions_json(both[0]),
        "worst": worst(both[0]),
        "worst_after": worst(both[1]),
    }
    return drawn, tables


def _same_data(first: Study, last: Study) -> bool:
    """Whether the last pass had the data of the first; of long data it may have had more."""
    return np.array_equal(first.problem.force, last.problem.force)


def _before(first: Study, last: Study) -> Array:
    """What the model before all passes predicts of the samples of the last one (n,) [N]."""
    on = None if _same_data(first, last) else last.problem
    return np.asarray(last.problem.force - left_of(first, first.diagnosis.base.fit, on))


def _told_later(study: Study, last: Study) -> bool:
    """Whether what a pass left of each record is told by the last one anyway."""
    return study is not last and _same_data(study, last)


def _later(study: Study, model: Model, asked: Question, *, straight: bool) -> dict[str, Any]:
    """The content of a pass after the first; straight: see `by_record`."""
    told = diagnosis_json(study, model) | dict(asked.level.particulars(study))
    told["by_record"] = by_record(study.diagnosis, study.problem, study.data, straight=straight)
    if study.checked is not None:
        told["long"] = study.checked.as_json(again=study.again)
    found: dict[str, Any] = clean(told)
    return found


def gone_on(result: DiagnosisResult, start: Begun) -> DiagnosisResult:
    """The result with a note where an interruption had left something to go on from."""
    if start.added is None:
        return result
    note = f"went on from where an interruption had left it, with {len(start.added)} done"
    return with_notes(result, note)
