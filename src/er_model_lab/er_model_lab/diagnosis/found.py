"""What a search for missing effects has found."""

from __future__ import annotations

from dataclasses import dataclass

from er_models.model import Model

from er_model_lab.diagnosis.candidates import Candidate
from er_model_lab.diagnosis.coverage import Coverage
from er_model_lab.diagnosis.noise_floor import Floor
from er_model_lab.diagnosis.null import Null
from er_model_lab.diagnosis.search import Round
from er_model_lab.diagnosis.verdict import Evidence, Verdict


@dataclass(frozen=True)
class Diagnosis:
    """Result of a diagnosis; `rounds` holds every step of the search, fewer where it was interrupted.

    further: what was tried beside the best model and not taken, where that was, as the first round of a search.
    beside: rounds that speak for effects that none of the others took.
    """

    verdict: Verdict
    effects: tuple[str, ...]
    alternatives: tuple[tuple[str, ...], ...]
    base: Candidate
    best: Candidate
    rounds: tuple[Round, ...]
    floor: Floor
    null: Null
    explainable: float
    explained: float
    coverage: Coverage
    reasons: tuple[str, ...]
    evidence: Evidence
    interrupted: bool = False
    further: Round | None = None
    beside: tuple[Round, ...] = ()

    @property
    def model(self) -> Model:
        """The model with the named effects, refitted."""
        return self.best.fit.model
