"""The cases of chapter 1 as JSON and as lines for a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from er_model_lab.identification import Identified
from er_model_lab.results.values import clean, parameters
from er_models.model import Model

from er_studies.given_out import Table
from er_studies.thesis.chapter_1 import ADDED, LAWS, PUBLISHED, ROADS, Case, Chapter1

STAND_IN = "The real damper is replaced by a simulated one that holds more than the models: compare orders, not digits."
KINDS = {
    "": "all parameters together",
    "_staged": "stage by stage",
    "_raw": "stage by stage, motion as measured",
    "_static": "static",
}
"""Ending of a model's name to what it is."""
WAYS_HEAD = (
    "NRMSE by way of identification",
    *(f"{law.capitalize()}, {road}" for road in ROADS.values() for law in LAWS),
)
CASE_2_HEAD = ("rms error [N]", "static", "dynamic", "static, turning", "dynamic, turning")
HEAD = (
    "NRMSE",
    *(f"{law.capitalize()}, {who}" for law in LAWS for who in ("thesis", "ours")),
    "truth itself",
)


def table_1_5(found: Chapter1) -> list[tuple[str, ...]]:
    """Rows of Table 1.5 under `HEAD`: the thesis's figures, on its damper, beside ours on the stand-in."""
    rows = []
    for name, road in ROADS.items():
        c, published = found.validation[name], PUBLISHED[name]
        pairs = [(f"{published[law]:.4f}", f"{c.nrmse(law):.4f}") for law in LAWS]
        rows.append((road, *(text for pair in pairs for text in pair), f"{c.nrmse('truth'):.4f}"))
    return rows


def ways(found: Chapter1) -> list[tuple[str, ...]]:
    """Rows (way of identification, NRMSE per road and law): what each step of ours changes."""
    rows = [
        (words, *(f"{found.validation[r].nrmse(law + end):.4f}" for r in ROADS for law in LAWS))
        for end, words in KINDS.items()
    ]
    more = (cell for r in ROADS for cell in ("-", f"{found.validation[r].nrmse('guo_added'):.4f}"))
    return [*rows, (f"all together, with {ADDED.replace('_', ' ').capitalize()}", *more)]


def static_against_dynamic(case: Case) -> list[tuple[str, ...]]:
    """Rows (model, error of the static and of the dynamic one [N], all samples and around zero velocity)."""
    rows = []
    for law in LAWS:
        errors = [
            case.rmse(f"{law}{end}", among)
            for among in (None, case.turning)
            for end in ("_static", "")
        ]
        rows.append((law.capitalize(), *(f"{e:.3f}" for e in errors)))
    return rows


def result(found: Chapter1, seed: int) -> dict[str, Any]:
    """Everything as plain data: NRMSE of every model on every case, parameters, response times."""
    cases = {"yield": found.tests, **found.validation}
    data: dict[str, Any] = clean({
        "command": "thesis chapter1", "seed": seed, "truth": found.truth.name,
        "table_1_5": {
            ROADS[name]: {
                law: {"thesis": PUBLISHED[name][law], "ours": found.validation[name].nrmse(law)}
                for law in LAWS
            }
            for name in ROADS
        },
        "cases": {name: errors(case) for name, case in cases.items()},
        "parameters": {law: _parameters(i.model) for law, i in found.identified.items()},
        "response_time": {law: response_time(i) for law, i in found.identified.items()},
        "tables": [table._asdict() for table in tables(found)],
    })  # fmt: skip
    return data


def errors(case: Case) -> dict[str, Any]:
    """RMSE [N], also around zero velocity, and NRMSE of every model."""
    return {
        model: {
            "rmse": case.rmse(model),
            "nrmse": case.nrmse(model),
            "rmse_turning": case.rmse(model, case.turning),
        }
        for model in case.forces
    }


def response_time(found: Identified) -> dict[str, Any]:
    """Response time [s] with its deviation at every duty held, and the quadratic (1.21) through them."""
    table, law = found.table, found.quadratic
    return {
        "duty": table.duty.tolist() if table else [],
        "tau": table.tau.tolist() if table else [],
        "sd": table.sd.tolist() if table else [],
        "quadratic": law.value.tolist() if law else None,
        "quadratic_sd": np.sqrt(np.diag(law.covariance)).tolist() if law else None,
    }


def _parameters(model: Model) -> Mapping[str, Any]:
    """Values of a model by effect: {name: [value, standard deviation, unit]}."""
    return {effect: parameters(model, effect) for effect in model.effects}


def tables(found: Chapter1) -> list[Table]:
    """Table 1.5, what each step changes, static against dynamic."""
    return [
        Table(HEAD, table_1_5(found)),
        Table(WAYS_HEAD, ways(found)),
        Table(CASE_2_HEAD, static_against_dynamic(found.tests)),
    ]


def lines(found: Chapter1) -> list[str]:
    """The screen."""
    return [
        STAND_IN,
        *(line for table in tables(found) for line in ("", *columns(table.head, table.rows))),
    ]


def columns(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """A table as lines of text: the first column to the left, the others to the right."""
    widths = [max(len(row[k]) for row in (head, *rows)) for k in range(len(head))]
    return [
        "  ".join(
            cell.ljust(w) if k == 0 else cell.rjust(w)
            for k, (cell, w) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in (head, *rows)
    ]
