"""All that differs between the levels of the lab: which data they take, how they open them, what they finish with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from er_models.model import Array, Model
from er_records.dataset import Dataset

from er_model_lab.diagnosis.rule import RULE, Rule
from er_model_lab.level.study import Opened, Study
from er_model_lab.preflight.check import Preflight
from er_model_lab.problem.fit_store import Notes
from er_model_lab.work import HERE, Work


@dataclass(frozen=True)
class Judged:
    """A model as it is, held against data.

    opened: the question, with what the model leaves; floor [N]; noise: mean square (n,) [N2] that noise makes of each
    sample; content: what the result holds beyond errors and regions.
    """

    opened: Opened
    floor: float
    noise: Array
    content: Mapping[str, Any]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Question:
    """What is asked.

    data: what is searched; preflight: what was found wrong with them, and what they cover; seed: of everything random;
    rule: when an effect is worth a name; work: how it is done; last: the study that made the model.
    """

    data: Dataset
    model: Model
    level: Level
    preflight: Preflight
    seed: int = 0
    rule: Rule = RULE
    work: Work = HERE
    last: Study | None = None


class Level(Protocol):
    """What is predicted of what; cost: work [s] by a second of data that a search takes one core."""

    name: str
    cost: float

    def usable(self, data: Dataset) -> Dataset:
        """The records that this level can use."""

    def given(self, asked: Question) -> Opened:
        """The data and what the model leaves of them as it is."""

    def judged(self, asked: Question) -> Judged:
        """The same beside the noise."""

    def reach_notes(self, opened: Opened) -> tuple[str, ...]:
        """What is said of data that go beyond what the model was fitted to."""

    def searched(self, asked: Question, noted: Notes | None) -> Study:
        """What the model lacks of the data; noted: fits made before, to which new ones are added."""

    def added(self, asked: Question, effect: str | None) -> Study:
        """One named effect, or none, judged alone."""

    def finished(self, study: Study, seed: int) -> Model:
        """The best model with estimates of everything that was fitted: values without bias, and deviations."""

    def particulars(self, study: Study) -> Mapping[str, Any]:
        """What the result of a diagnosis holds beside what every level tells."""
