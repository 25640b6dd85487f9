"""Start models: one of a kind scaled to data, and those that are shipped."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from er_models.files import load_model
from er_models.model import Model
from er_models.shipped import MODELS, names, shipped
from er_records.dataset import Dataset

from er_model_lab.fitting.kinds import KINDS
from er_model_lab.fitting.start_model import start_model
from er_model_lab.preflight.check import admitted

NAMED = {"mr": {"mr"}, "friction": {"friction", "brake", "seal"}, "passive": {"passive"}}
"""Words in a shipped model's name that tell its kind; the thesis's are electrorheological."""


@dataclass(frozen=True)
class Shipped:
    """A model that comes with the package: its name, its file, and the model."""

    name: str
    file: Path
    model: Model

    @property
    def kind(self) -> str:
        """What it is a model of: a car, or a kind of `lab new`, by the words of its name."""
        if self.model.is_vehicle:
            return "car"
        words = {*self.name.split("_")}
        return next((kind for kind, own in NAMED.items() if own & words), "er")


def new(data: Dataset, kind: str, *, name: str | None = None, anyway: bool = False) -> Model:
    """A start model of a kind (`er`, `mr`, `passive`, `friction`), scaled to the data, its rig as far as they reach.

    The data need a force and a deflection; without a duty it counts as 0. Coefficients that the force is linear in are
    fitted, all others start where the catalogue says. anyway: data that fail the preflight are used all the same.

    Raises:
        UnknownName: No such kind.
        MissingChannel: No force or no deflection.
        InputError: Data that fail the preflight.
    """
    _, records = admitted(data.learn, anyway=anyway)
    return start_model(records, kind, name or f"start_{kind}")


def models() -> tuple[Shipped, ...]:
    """The models that come with the package, in the order of their names; `load_model` takes the name."""
    found = ((name, shipped(name, *MODELS)) for name in names(*MODELS))
    return tuple(Shipped(name, file, load_model(file)) for name, file in found)


__all__ = ["KINDS", "Shipped", "models", "new"]
