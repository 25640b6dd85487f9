"""The level of the vehicle: all outputs of a car, predicted from its road and duty."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from er_models.model import Model
from er_records.dataset import Dataset

from er_model_lab.diagnosis.investigation import one_effect, search_effects
from er_model_lab.fitting.deviations import with_deviations
from er_model_lab.fitting.envelope import with_unfelt
from er_model_lab.fitting.fit import fit
from er_model_lab.level.car_outputs import after, as_given, confounded, white
from er_model_lab.level.level import Judged, Question
from er_model_lab.level.study import Opened, Study
from er_model_lab.problem.fit_store import Notes
from er_model_lab.problem.problem import Problem
from er_model_lab.residual.excess import noise_at
from er_model_lab.span.span import All
from er_model_lab.vehicle.ride_problem import open_ride, ride_as_given


class VehicleLevel:
    """Everything that was measured of a car."""

    name, cost = "vehicle", 3.0

    def usable(self, data: Dataset) -> Dataset:
        """All records."""
        return data

    def given(self, asked: Question) -> Opened:
        """The data and what the model leaves of them; nothing but the starts of the blocks is fitted."""
        problem, left = ride_as_given(asked.data, asked.model)
        return Opened(asked.data, asked.model, asked.model, problem, All(), left)

    def judged(self, asked: Question) -> Judged:
        """The same with the white noise of the first output, and the errors of every output."""
        found = self.given(asked)
        problem, left = found.problem, found.given
        floor = white(problem, left, 0)
        content = {"level": self.name, "channels": as_given(problem, left)}
        return Judged(found, floor, noise_at(problem, floor, 0.0 * left), content, ())

    def reach_notes(self, opened: Opened) -> tuple[str, ...]:
        """Nothing: the reach of a car is not kept."""
        del opened
        return ()

    def searched(self, asked: Question, noted: Notes | None) -> Study:
        """What the model lacks; sensors are simulated, nothing is undone before."""
        problem, fitted = open_ride(asked.data, asked.model, asked.work)
        problem = replace(problem, noted=noted)
        seen = search_effects(fitted.model, problem, seed=asked.seed, rule=asked.rule)
        return Study(_opened(asked, problem), seen)

    def added(self, asked: Question, effect: str | None) -> Study:
        """One effect, or none, judged alone."""
        problem, fitted = open_ride(asked.data, asked.model, asked.work)
        return Study(
            _opened(asked, problem), one_effect(fitted.model, problem, effect, asked.seed)
        )

    def finished(self, study: Study, seed: int) -> Model:
        """The fit brought to its end, with deviations."""
        del seed
        best, problem = study.diagnosis.best.fit, study.problem
        if (
            not study.diagnosis.interrupted
        ):  # else whoever stopped it does not wait for a better one
            best = fit(best.model, problem, tol=1e-7)
        found = with_deviations(best, problem)
        return with_unfelt(found, study.model, problem)

    def particulars(self, study: Study) -> Mapping[str, Any]:
        """Errors of every output, and groups of parameters that the data cannot tell apart."""
        return {
            "level": self.name,
            "channels": after(study),
            "confounded": confounded(study.diagnosis.best.fit, study.problem),
        }


def _opened(asked: Question, problem: Problem) -> Opened:
    """The question with what the model leaves as it was given."""
    given = problem.force - problem.predict(asked.model)
    return Opened(asked.data, asked.model, asked.model, problem, All(), given)
