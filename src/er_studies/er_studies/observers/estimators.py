"""What is compared: our observers with the gains of a folder, and the Kalman filters, behind one face."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from er_models.linear import LinearForm
from er_models.model import Array, Model
from er_observers.programs import OBSERVERS
from er_observers.running.ready import ready
from er_observers.running.runtime import Estimate, Sample, start, step

from er_studies.observers import kalman

Start = Callable[[Any, Sample, Array | None], Any]
Step = Callable[[Any, Any, Sample], tuple[Any, Estimate]]


@dataclass(frozen=True, eq=False)
class Estimator:
    """One way to the force: `start(parameters, sample, x)`, `step(parameters, state, sample)`.

    name: short, as in files; title: for people; ours: whether it is one of the observers.
    """

    name: str
    title: str
    ours: bool
    parameters: Any
    start: Start
    step: Step
    form: LinearForm


_OURS = sorted(OBSERVERS, key=lambda name: name == "unified")
"""The unified observer last, as in the thesis's tables."""


def estimators_of(model: Model, gains: str | Path) -> tuple[Estimator, ...]:
    """Every observer that has a gain file in the folder, then the peers.

    Raises `InputError` when a gain file does not belong to the model.
    """
    found = []
    for name in _OURS:
        path = Path(gains) / f"{name}.yaml"
        if path.exists():
            loaded = ready(path, model, name)
            found.append(
                Estimator(name, OBSERVERS[name].title, True, loaded, start, step, loaded.form)
            )
    for name, kind in kalman.KINDS.items():
        made = kalman.make(name, model)
        found.append(
            Estimator(name, kind.title, False, made, kalman.start, kalman.step, made.form)
        )
    return tuple(found)


def gains_alone(estimator: Estimator) -> Estimator | None:
    """An observer without its start phase: its proved gain from the first sample on; None for all else."""
    if not estimator.ours or estimator.parameters.opening is None:
        return None
    return replace(estimator, parameters=replace(estimator.parameters, opening=None))
