"""What every command of the lab is asked, and what it gives."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from er_models.catalogue import Catalogue
from er_models.errors import InputError
from er_models.files import load_model
from er_models.model import Model
from er_models.own import catalogue_with

from er_model_lab.command_line import command_line
from er_model_lab.diagnosis.rule import RULE, Rule
from er_model_lab.preflight.check import gate
from er_model_lab.problem.stretches import shortened
from er_model_lab.records.copies import check_apart
from er_model_lab.records.duty_known import driven
from er_model_lab.records.load import fingerprint, load, told_apart
from er_model_lab.records.record import Record, originals
from er_model_lab.results.view import View
from er_model_lab.versions import versions


@dataclass(frozen=True)
class Request:
    """What every command is asked: data, data that only score (may be empty), model file and seed.

    effects_from: Python files with the user's own effects; rule: when an effect is worth a name;
    level: damper or vehicle; anyway: whether data that fail the preflight are used all the same;
    rivals: further models for `compare`.
    """

    data: list[Path]
    model_file: Path
    seed: int = 0
    hold_out: tuple[Path, ...] = ()
    effects_from: tuple[Path, ...] = ()
    rule: Rule = RULE
    level: str = "damper"
    anyway: bool = False
    rivals: tuple[Path, ...] = ()

    @property
    def catalogue(self) -> Catalogue:
        """The catalogue with the user's own effects."""
        return catalogue_with(self.effects_from)

    def model(self) -> Model:
        """The model as its file has it."""
        return load_model(self.model_file, self.catalogue)

    def others(self) -> list[tuple[Path, Model]]:
        """Further models to compare with it."""
        return [(path, load_model(path, self.catalogue)) for path in self.rivals]


@dataclass(frozen=True)
class Outcome:
    """Result of a command: the contract's JSON, what to draw, and the new model if there is one.

    interrupted: Ctrl-C ended it, and what was done until then is in the result.
    """

    result: dict[str, Any]
    view: View
    model: Model | None
    complete: bool
    interrupted: bool = False


def read(ask: Request) -> tuple[list[Record], int]:
    """Records to learn from followed by those that only score, and how many the latter are.

    Of data that are too long to be searched whole, stretches of them.
    """
    records = load(ask.data)
    sealed = load(ask.hold_out) if ask.hold_out else []
    if not records:
        raise InputError(ask.data[0], "", "at least one record", "none")
    check_apart(records, sealed)
    data = gate(told_apart([*records, *sealed]), anyway=ask.anyway)
    if ask.level == "vehicle":
        return shortened(data, len(sealed))
    return shortened(*driven(data, len(sealed)))


def provenance(records: list[Record], model: Model, ask: Request) -> dict[str, Any]:
    """Where a result comes from: data, model, seed and versions."""
    data = originals(records)
    return {
        "data": fingerprint(data), "records": [r.name for r in data], "model_file": str(ask.model_file),
        "model": model.digest(), "seed": ask.seed, "versions": versions(), "command_line": command_line(),
        "effects_from": {name: asdict(o) for name, o in model.catalogue.origins.items()},
    }  # fmt: skip
