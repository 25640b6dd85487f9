"""The contract's JSON of `compare`."""

from __future__ import annotations

from typing import Any

import numpy as np
from er_models.model import Array

from er_model_lab.problem.problem import Problem
from er_model_lab.residual.errors import errors, explainable, regions_json, worst
from er_model_lab.residual.region import RegionTable


def compare_json(
    problem: Problem, given: Array, floor: float, tables: tuple[RegionTable, ...]
) -> dict[str, Any]:
    """The contract's JSON of `compare`; given (n,): what the model leaves [N]."""
    whole = errors(problem, given, problem.used)
    m, rows = problem.motion, problem.forward.outputs
    by_record = {}
    for name, i, j in zip(problem.names, m.starts[:-1], m.starts[1:], strict=True):
        mask = np.zeros(problem.force.size, bool)
        mask[i * rows : j * rows] = True
        by_record[name] = errors(problem, given, mask & problem.used).rmse
    return {
        "rmse": whole.rmse, "nrmse": whole.nrmse, "noise_floor": floor,
        "explainable": explainable(whole.rmse**2, floor),
        "worst": worst(tables), "regions": regions_json(tables), "rmse_by_record": by_record,
        "notes": list(problem.notes), "complete": problem.complete,
    }  # fmt: skip
