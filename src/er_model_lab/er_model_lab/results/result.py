"""What every verb of the lab returns: frozen records that print, tabulate, draw and report themselves."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from copy import deepcopy
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from er_common.extras import extra
from er_models.errors import InputError
from er_models.model import Model
from er_models.program import Program

from er_model_lab.diagnosis.verdict import Verdict
from er_model_lab.output.text.units import newtons, short
from er_model_lab.results.records import CandidateResult, Errors, Parameter, Step, of
from er_model_lab.view import View

if TYPE_CHECKING:
    import pandas as pd

    from er_model_lab.output.report.still import Drawing

    Row = Mapping[str, Any]


@dataclass(frozen=True, repr=False)
class Result:
    """What a verb found; SI units throughout.

    view: all that texts and pictures are made of; model: the new model where the verb makes one; interrupted: it was
    stopped, and what was done until then is here.
    """

    view: View
    model: Model | None = None
    interrupted: bool = False

    @property
    def complete(self) -> bool:
        """Whether the data were complete; the notes say what was lost or repaired."""
        return bool(self.view.result.get("complete", True))

    @property
    def notes(self) -> tuple[str, ...]:
        """What to know of data and model, in sentences."""
        return self.view.notes

    @property
    def figures(self) -> tuple[str, ...]:
        """Names of the figures that `figure` draws."""
        with extra("er_model_lab[plots]", "a figure"):
            from er_model_lab.output.report.page import figures_of

        return tuple(figures_of(self.view))

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain data, as `--json` of the command of the same name writes it."""
        return deepcopy(dict(self.view.result))

    def to_frame(self) -> pd.DataFrame:
        """The rows that matter most as a table, units in the names of the columns; needs pandas."""
        import pandas as pd

        return pd.DataFrame(list(self._rows()))

    def figure(self, name: str) -> Drawing:
        """One figure of the report, drawn by Matplotlib.

        Raises:
            InputError: There is no figure of that name.
            ErError: A package that draws is not installed.
        """
        with extra("er_model_lab[plots]", "a figure"):
            from er_model_lab.output.report.page import figures_of
            from er_model_lab.output.report.still import canvas

        found = figures_of(self.view)
        if name not in found:
            raise InputError("figure", "", f"one of {', '.join(found)}", name)
        return canvas(found[name])

    def report(self, folder: str | Path) -> Path:
        """Write a page that opens offline, and every figure as PNG and SVG, into a folder; returns the page.

        Raises:
            InputError: The folder cannot be written.
            ErError: A package that draws is not installed.
        """
        with extra("er_model_lab[plots]", "a report"):
            from er_model_lab.output.report.page import write_report

        return write_report(self.view, Path(folder))

    def _rows(self) -> Iterable[Row]:
        """Rows of the table."""
        return ()

    def _facts(self) -> tuple[str, ...]:
        """The result in a few words."""
        return (self.view.headline,)

    def __repr__(self) -> str:
        facts = "; ".join((self.view.model, *self._facts()))
        return f"<{type(self).__name__} {facts}>"

    def _repr_html_(self) -> str:
        """For notebooks: the facts, and the table below them."""
        head = "".join(f"<li>{escape(fact)}</li>" for fact in self._facts())
        title = escape(f"{self.view.command} {self.view.model}")
        return f"<b>{title}</b><ul>{head}</ul>{_table(list(self._rows()))}"


def _table(rows: list[Row]) -> str:
    """Rows as an HTML table; empty where there are none."""
    if not rows:
        return ""
    head = "".join(f"<th>{escape(name)}</th>" for name in rows[0])
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(_cell(value))}</td>" for value in row.values()) + "</tr>"
        for row in rows
    )
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _cell(value: Any) -> str:
    """A value as a reader sees it."""
    if isinstance(value, float):
        return short(value)
    return "" if value is None else str(value)


@dataclass(frozen=True, repr=False)
class DiagnosisResult(Result):
    """What `diagnose`, `add` or `improve` found; `model` is the best one, refitted, with deviations."""

    @property
    def verdict(self) -> Verdict:
        """One of adequate, missing_effect, ambiguous, partial, unknown_effect, insufficient_data."""
        found: Verdict = self.view.result["verdict"]
        return found

    @property
    def effects(self) -> tuple[str, ...]:
        """Effects that are missing, most important first."""
        return tuple(self.view.result["effects"])

    @property
    def alternatives(self) -> tuple[tuple[str, ...], ...]:
        """Groups of effects that the data cannot tell apart."""
        return tuple(map(tuple, self.view.result["alternatives"]))

    @property
    def rmse(self) -> Errors:
        """Root mean square error of the refitted model before anything is added [N]."""
        return Errors.of(self.view.result["rmse"])

    @property
    def rmse_after(self) -> Errors:
        """The same with the effects that were found [N]."""
        return Errors.of(self.view.result["rmse_after"])

    @property
    def noise_floor(self) -> float:
        """What no model of these inputs could explain, on held-out data [N]."""
        return float(self.view.result["noise_floor"])

    @property
    def explainable(self) -> float:
        """Share of the squared error that some model could explain [1]."""
        return float(self.view.result["explainable"])

    @property
    def candidates(self) -> tuple[CandidateResult, ...]:
        """Every effect that was tried: those that were named first, then by their error."""
        return tuple(map(CandidateResult.of, self.view.result["candidates"]))

    @property
    def evidence(self) -> tuple[CandidateResult, ...]:
        """The candidates that the verdict rests on: what was named, and what is tied with it."""
        known = {*self.effects, *(name for group in self.alternatives for name in group)}
        return tuple(c for c in self.candidates if c.effect in known)

    @property
    def steps(self) -> tuple[Step, ...]:
        """The fall of the held-out error, one step an effect."""
        return tuple(of(Step, s) for s in self.view.result["steps"])

    @property
    def reasons(self) -> tuple[str, ...]:
        """Why the verdict is what it is, in sentences."""
        return tuple(self.view.result["reasons"])

    def _facts(self) -> tuple[str, ...]:
        names = f": {', '.join(self.effects)}" if self.effects else ""
        after = self.view.result["rmse_after"]["held_out"]
        fall = f"held out {newtons(self.rmse.held_out)}"
        fall += f" to {newtons(after)}" if self.effects else ""
        return (f"{self.verdict}{names}", f"{fall}, noise floor {newtons(self.noise_floor)}")

    def _rows(self) -> Iterable[Row]:
        return (c.row for c in self.candidates)


@dataclass(frozen=True, repr=False)
class ComparisonResult(Result):
    """What `compare` found: how far the model as it is misses the data, and where."""

    @property
    def rmse(self) -> float:
        """Root mean square error over all scored samples [N]."""
        return float(self.view.result["rmse"])

    @property
    def nrmse(self) -> float:
        """The same over the range of the measured force [1], thesis (3.79)."""
        return float(self.view.result["nrmse"])

    @property
    def noise_floor(self) -> float:
        """What no model of these inputs could explain [N]."""
        return float(self.view.result["noise_floor"])

    @property
    def explainable(self) -> float:
        """Share of the squared error that some model could explain [1]."""
        return float(self.view.result["explainable"])

    @property
    def worst(self) -> tuple[Row, ...]:
        """Regions that carry more of the error than of the data, heaviest first."""
        return tuple(self.view.result["worst"])

    def _rows(self) -> Iterable[Row]:
        for region in self.worst:
            low, high = region["from"], region["to"]
            yield {
                "quantity": region["quantity"], "from": low, "to": high, "unit": region["unit"],
                "share_of_error": region["share"], "share_of_data": region["of_samples"], "rmse [N]": region["rmse"],
            }  # fmt: skip


@dataclass(frozen=True, repr=False)
class IdentificationResult(Result):
    """What `identify` found; `model` holds the identified values with their deviations."""

    @property
    def verdict(self) -> str:
        """Identified or identified_in_part."""
        return str(self.view.result["verdict"])

    @property
    def rmse(self) -> Errors:
        """Root mean square error of the model as it was given [N]."""
        return Errors.of(self.view.result["rmse"])

    @property
    def rmse_after(self) -> Errors:
        """The same of the identified model [N]."""
        return Errors.of(self.view.result["rmse_after"])

    @property
    def parameters(self) -> Mapping[str, Parameter]:
        """Every parameter as `effect.name`."""
        return {
            f"{effect}.{name}": Parameter(p["value"], p["sd"], p["unit"])
            for effect, values in self.view.result["parameters"].items()
            for name, p in values.items()
        }

    def _facts(self) -> tuple[str, ...]:
        return (self.verdict, self.view.headline)

    def _rows(self) -> Iterable[Row]:
        for effect, values in self.view.result["parameters"].items():
            for name, p in values.items():
                yield {
                    "effect": effect, "parameter": name, "value": p["value"], "sd": p["sd"], "unit": p["unit"],
                    "before": p["before"], "status": p["status"],
                }  # fmt: skip


@dataclass(frozen=True, repr=False)
class PlanResult(Result):
    """What `plan` found; `program` is the run to record, None where nothing within the limits decides."""

    program: Program | None = None

    @property
    def verdict(self) -> str:
        """told_apart, one_way, not_told_apart, revealed or not_revealed."""
        return str(self.view.result["verdict"])

    def _facts(self) -> tuple[str, ...]:
        return (self.verdict, self.view.headline)

    def _rows(self) -> Iterable[Row]:
        for found in self.view.result["programs"]:
            separation = {f"separation of {n}": s for n, s in found["separation"].items()}
            yield {"program": found["name"], **separation, **found["used"]}


@dataclass(frozen=True, repr=False)
class CheckResult(Result):
    """What `check` found in the data."""

    @property
    def verdict(self) -> str:
        """Usable or not_usable."""
        return str(self.view.result["verdict"])

    @property
    def findings(self) -> tuple[Row, ...]:
        """Everything that was checked, worst first."""
        return tuple(self.view.result["preflight"]["findings"])

    def _facts(self) -> tuple[str, ...]:
        return (self.verdict, self.view.headline)

    def _rows(self) -> Iterable[Row]:
        return self.findings


R = TypeVar("R", bound=Result)


def with_notes(result: R, *first: str, last: Iterable[str] = ()) -> R:
    """The result with further notes before its own, and after them."""
    view = result.view
    content = dict(view.result) | {"notes": [*first, *view.result["notes"], *last]}
    return replace(result, view=replace(view, result=content, notes=(*first, *view.notes, *last)))
