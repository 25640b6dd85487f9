"""All that differs between data that are searched whole and long data, of which stretches are."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

from er_models.model import Array, Model
from er_records.dataset import Dataset

from er_model_lab.fitting.deviations import with_deviations
from er_model_lab.fitting.estimate import estimated
from er_model_lab.fitting.fit import Fit, fit
from er_model_lab.problem.problem import Problem
from er_model_lab.span.check import Checked, checked
from er_model_lab.span.whole_record import WholeRecords, on_whole, remembers


class Span(Protocol):
    """How much of the data a problem holds."""

    def estimate(self, fitted: Fit, problem: Problem, seed: int, given: Model) -> Model:
        """The model of a fit with estimates of everything that was fitted: values without bias, and deviations.

        given: the model before the fit.
        """

    def checked(self, problem: Problem, residual: Array, **models: Model) -> Checked | None:
        """What each model leaves of all data; None where all were searched.

        residual: (n,) of the last model on the samples searched [N].
        """


class All:
    """All data are searched."""

    def estimate(self, fitted: Fit, problem: Problem, seed: int, given: Model) -> Model:
        """Estimates from the data as they are."""
        return estimated(fitted, problem, seed, given)

    def checked(self, problem: Problem, residual: Array, **models: Model) -> None:
        """Nothing is left to check."""
        del problem, residual, models


@dataclass(frozen=True)
class Stretches:
    """Stretches of long data are searched."""

    whole: WholeRecords

    def estimate(self, fitted: Fit, problem: Problem, seed: int, given: Model) -> Model:
        """Estimates from the stretches; of what remembers more than a stretch, from whole records."""
        if remembers(fitted.model):
            return with_deviations(fit(fitted.model, problem, tol=1e-7), problem)
        return estimated(fitted, problem, seed, given)

    def checked(self, problem: Problem, residual: Array, **models: Model) -> Checked:
        """All data predicted with each model."""
        score = problem.held_out if problem.held_out.any() else problem.train
        return checked(self.whole, residual[score], **models)


def spanned(problem: Problem, data: Dataset) -> tuple[Problem, Span]:
    """A problem with the motion, the past and the time that its samples have in whole records, and its span."""
    if data.whole is None:
        return problem, All()
    settled, whole = on_whole(problem, data)
    return settled, Stretches(whole)


def noted(problem: Problem, found: Checked | None, *, again: bool = False) -> Problem:
    """The problem with a note of what was used of long data; as it is where all was. again: searched a second time."""
    if found is None:
        return problem
    return replace(problem, notes=(found.note(again=again), *problem.notes))
