"""Typed parts of a result: errors, parameters with unit and deviation, candidates, steps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, TypeVar

from er_model_lab.output.text.units import newtons, parameter

Row = Mapping[str, Any]
T = TypeVar("T")


def of(kind: type[T], entry: Row) -> T:
    """A record from the entry of a result, of the keys that it knows."""
    names = {f.name for f in fields(kind)}  # type: ignore[arg-type]
    return kind(**{k: v for k, v in entry.items() if k in names})


@dataclass(frozen=True)
class Errors:
    """Root mean square errors [N]: of the data learnt from, and of those held out; None where there are none."""

    train: float | None
    held_out: float | None

    @classmethod
    def of(cls, entry: Row) -> Errors:
        """From the entry of a result."""
        return cls(entry.get("train"), entry.get("held_out"))

    def __str__(self) -> str:
        return f"{newtons(self.train)} learnt from, {newtons(self.held_out)} held out"


@dataclass(frozen=True)
class Parameter:
    """A value with its standard deviation (None: the data do not show it) and SI unit."""

    value: float
    sd: float | None
    unit: str

    def __str__(self) -> str:
        return parameter([self.value, self.sd, self.unit])


@dataclass(frozen=True)
class Step:
    """One step of the fall: what was added (None: the refitted model), and the errors then [N]."""

    added: str | None
    rmse_held_out: float
    rmse_train: float | None = None

    @property
    def errors(self) -> Errors:
        """Both as one."""
        return Errors(self.rmse_train, self.rmse_held_out)


@dataclass(frozen=True)
class CandidateResult:
    """One effect as the lab judged it.

    size: root of the fall of the mean square on data left out [N]; threshold: what chance reaches [N]; p_value: of
    that size in a complete model; status: present, absent, not_excited or confounded (with which others).
    """

    effect: str
    status: str
    rmse_held_out: float
    size: float
    threshold: float | None
    p_value: float
    parameters: Mapping[str, Parameter]
    confounded_with: tuple[str, ...]

    @classmethod
    def of(cls, entry: Row) -> CandidateResult:
        """From the entry of a result."""
        return cls(
            entry["effect"], entry["status"], entry["rmse_held_out"], entry["evidence"], entry.get("threshold"),
            entry["p_value"], {name: Parameter(*p) for name, p in entry["parameters"].items()},
            tuple(entry["confounded_with"]),
        )  # fmt: skip

    @property
    def row(self) -> dict[str, Any]:
        """As a row of a table."""
        return {
            "effect": self.effect, "status": self.status, "rmse_held_out [N]": self.rmse_held_out,
            "size [N]": self.size, "p_value": self.p_value,
            "parameters": ", ".join(f"{name} = {p}" for name, p in self.parameters.items()),
        }  # fmt: skip
