"""A data set opened as a question to a model, and what came of it."""

from __future__ import annotations

from dataclasses import dataclass, replace

from er_models.model import Array, Model
from er_records.dataset import Dataset

from er_model_lab.diagnosis import decisive_round
from er_model_lab.diagnosis.candidates import Candidate
from er_model_lab.diagnosis.found import Diagnosis
from er_model_lab.fitting.deviations import with_deviations
from er_model_lab.fitting.fit import summed_up
from er_model_lab.fitting.velocity_channel import as_searched
from er_model_lab.problem.problem import Problem
from er_model_lab.span.check import Checked
from er_model_lab.span.span import Span, noted

Lag = tuple[float, float]
"""Lag of the velocity channel and its standard deviation [s]."""


@dataclass(frozen=True)
class Opened:
    """A data set as a question to a model.

    data: records, or the stretches of them that are searched; model: as it was given; searched: the same as it is
    searched, without what was undone in the data; given: what the model leaves as it was given (n,) [N]; lag: of the
    velocity channel where it was found and undone.
    """

    data: Dataset
    model: Model
    searched: Model
    problem: Problem
    span: Span
    given: Array
    lag: Lag | None = None


@dataclass(frozen=True)
class Study:
    """A diagnosis with the data before and after what the sensors were found to do.

    before: the model refitted on the channel as it was measured, where that was found to lag; checked: the models
    before and after on all of long data; again: whether the worst of these were searched as well; learnt: whether the
    best model holds a measured term with estimates of its own.
    """

    opened: Opened
    diagnosis: Diagnosis
    before: Candidate | None = None
    checked: Checked | None = None
    again: bool = False
    learnt: bool = False

    @property
    def problem(self) -> Problem:
        """The problem that was diagnosed."""
        return self.opened.problem

    @property
    def data(self) -> Dataset:
        """The data that were searched."""
        return self.opened.data

    @property
    def model(self) -> Model:
        """The model as it was given."""
        return self.opened.model


def checked(study: Study) -> Study:
    """The study with the models before and after the search on all of the data, where only a part was searched."""
    found = study.diagnosis
    before, after = as_searched(found.base.fit), as_searched(found.best.fit)
    problem, span = study.problem, study.opened.span
    whole = span.checked(problem, found.best.fit.residual, before=before, after=after)
    return replace(study, checked=whole)


def summary(study: Study) -> Study:
    """The study without the derivatives of what no round took, which are most of its memory.

    Those whose numbers are told have their deviations instead.
    """
    problem, found = study.problem, study.diagnosis
    shown = {id(c) for c, _ in decisive_round.told(found)}

    def summed(c: Candidate) -> Candidate:
        model = with_deviations(c.fit, problem) if id(c) in shown else c.fit.model
        return replace(c, fit=summed_up(c.fit, model))

    rounds = tuple(
        replace(s, candidates=[c if c is s.taken else summed(c) for c in s.candidates])
        for s in found.rounds
    )
    return replace(study, diagnosis=replace(found, rounds=rounds, further=None))


def told(study: Study, *, again: bool) -> Study:
    """The study with a note of what was found on all of long data."""
    problem = noted(study.problem, study.checked, again=again)
    return replace(study, opened=replace(study.opened, problem=problem), again=again)
