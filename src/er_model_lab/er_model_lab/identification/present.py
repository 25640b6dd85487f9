"""An identification as JSON, as a view to draw, and as a model file with its history."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from er_models.model import Model

from er_model_lab.fitting.data_reach import REACH, reach
from er_model_lab.fitting.envelope import in_bounds
from er_model_lab.fitting.rig import kept_up, with_old_envelope
from er_model_lab.identification.findings import findings, missing, verdict
from er_model_lab.identification.law import response_time
from er_model_lab.identification.procedure import Identified
from er_model_lab.identification.stages import Stage
from er_model_lab.residual.errors import errors
from er_model_lab.residual.excess import region_tables
from er_model_lab.results.draw import views
from er_model_lab.results.values import clean, headline
from er_model_lab.view import View

CURVE = 61
"""Points of the law of the response time."""


def identified_json(found: Identified) -> dict[str, Any]:
    """The result of `lab identify`."""
    problem = found.problem
    lacks = missing(found)
    before, after = _errors(found, found.given), _errors(found, found.residual)
    result: dict[str, Any] = clean({
        "command": "identify",
        "verdict": verdict(found),
        "model": found.model.name,
        "parameters": parameters(found),
        "correlation": {
            "names": [f"{e}.{n}" for e, n in found.refined.fit.free],
            "matrix": found.refined.visibility.correlation.tolist(),
        },
        "stages": [_stage(stage) for stage in found.stages],
        "levels": [
            {"duty": level.duty, "samples": int(level.rows.sum())} for level in found.levels
        ],
        "response_time": _response(found),
        "rmse": {k: e[0] for k, e in before.items()},
        "rmse_after": {k: e[0] for k, e in after.items()},
        "nrmse": {k: e[1] for k, e in before.items()},
        "nrmse_after": {k: e[1] for k, e in after.items()},
        "noise_floor": problem.sd_force,
        "missing": lacks,
        "reasons": [*lacks, *findings(found)],
        "notes": list(problem.notes),
        "complete": problem.complete and not lacks,
    })  # fmt: skip
    return result


def parameters(found: Identified) -> dict[str, dict[str, dict[str, Any]]]:
    """Every parameter of the model: value, deviation, unit, value before, and what the data say of it."""
    return {
        effect: {
            q.name: _parameter(found, effect, q.name)
            for q in found.model.catalogue[effect].parameters
        }
        for effect in found.model.effects
    }


def view(
    found: Identified, result: Mapping[str, Any], seed: int, provenance: Mapping[str, Any]
) -> View:
    """Everything the report of `lab identify` shows."""
    problem = found.problem
    after, noise = result["rmse_after"], np.full(problem.force.size, problem.sd_force**2)
    return View(
        command="identify", model=found.model.name, headline=headline(after["train"], problem.sd_force),
        result=result, records=views(problem, problem.force - found.given, problem.force - found.residual),
        regions=region_tables(problem, found.residual, seed, noise),
        notes=tuple(result["missing"]) + problem.notes,
        provenance=provenance,
    )  # fmt: skip


def new_model(found: Identified, name: str, entry: Mapping[str, Any]) -> Model:
    """The identified model under its new name, with one entry of history more."""
    fitted = [f"{e}.{n}" for e, n in found.refined.fit.free]
    whole = {"identified": fitted, "held": [f"{e}.{n}" for e, n in found.held], **entry}
    whole["rmse"] = {
        "before": _errors(found, found.given)["train"][0],
        "after": _errors(found, found.residual)["train"][0],
    }
    whole["from"] = found.before.name
    whole[REACH] = reach(found.problem)
    source = (
        f"identified from {len(entry['records'])} records, beginning from '{found.before.name}'"
    )
    model = replace(found.model, name=name, source=f"{source} ({found.before.source})",
                    history=(*found.before.history, whole))  # fmt: skip
    bounded = in_bounds(model, found.problem, found.before.scales)
    return with_old_envelope(kept_up(bounded, found.problem), found.before)


def _parameter(found: Identified, effect: str, name: str) -> dict[str, Any]:
    """One parameter as the result states it."""
    fit, seen = found.refined.fit, found.refined.visibility
    out: dict[str, Any] = {
        "value": found.model.value(effect, name),
        "sd": None,
        "unit": found.model.catalogue[effect].parameter(name).unit,
        "before": found.before.value(effect, name),
    }
    if (effect, name) in found.held:
        return out | {"status": "not_identified"}
    if (effect, name) not in fit.free:
        return out | {"status": "given"}
    i = fit.free.index((effect, name))
    tied = any((effect, name) in others for others in found.refined.taken_up.values())
    status = (
        "at_bound" if fit.at_bound[i]
        else "conditional" if tied else "weak" if seen.weak[i] else "identified"
    )  # fmt: skip
    sd = float(np.sqrt(max(seen.covariance[i, i], 0.0)))
    return out | {"sd": sd, "status": status, "visible": float(seen.visible[i])}


def _stage(stage: Stage) -> dict[str, Any]:
    """What one stage gave on its own."""
    model = stage.model
    values: dict[str, Any] = {
        f"{e}.{n}": [
            model.value(e, n), model.deviations.get(e, {}).get(n), model.catalogue[e].parameter(n).unit
        ]
        for e, n in stage.free
    }  # fmt: skip
    if not stage.done:
        return {"stage": stage.name, "done": False, "why": stage.left_out}
    return {
        "stage": stage.name, "done": True, "samples": stage.samples, "rmse": stage.rmse, "parameters": values,
    }  # fmt: skip


def _response(found: Identified) -> dict[str, Any] | None:
    """Response time of the levels, the quadratic through them, and the model's law."""
    table, curve = found.table, found.quadratic
    if table is None:
        return None
    duty = np.linspace(0.0, float(table.duty.max()), CURVE)
    out: dict[str, Any] = {
        "levels": [
            {"duty": u, "tau": tau, "sd": sd}
            for u, tau, sd in zip(table.duty, table.tau, table.sd, strict=True)
        ],
        "model": {"duty": duty.tolist(), "tau": response_time(found.model, duty).tolist()},
        "quadratic": None,
    }
    if curve is not None:
        sd = np.sqrt(np.maximum(np.diag(curve.covariance), 0.0))
        out["quadratic"] = {
            "tau_0": [curve.value[0], sd[0], "s"], "tau_1": [curve.value[1], sd[1], "s/duty"],
            "tau_2": [curve.value[2], sd[2], "s/duty2"], "chi2": curve.chi2, "freedom": curve.freedom,
        }  # fmt: skip
    return out


def _errors(found: Identified, residual: np.ndarray) -> dict[str, tuple[float, float]]:
    """RMSE [N] and NRMSE of the training samples, and of the held-out ones where there are any."""
    problem = found.problem
    masks = {"train": problem.train, "held_out": problem.held_out}
    kept = {k: errors(problem, residual, mask) for k, mask in masks.items() if mask.any()}
    return {k: (e.rmse, e.nrmse) for k, e in kept.items()}
