"""Comparison at the level of the vehicle: everything that was measured of a car, predicted from road and duty."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from er_models.model import Array

from er_model_lab.motion.white_noise import white_noise
from er_model_lab.preflight.check import preflight
from er_model_lab.problem.problem import Problem
from er_model_lab.records.load import fingerprint
from er_model_lab.records.record import CHANNELS, originals
from er_model_lab.residual.errors import explainable
from er_model_lab.residual.excess import noise_at, region_tables
from er_model_lab.results.comparison import compare_json
from er_model_lab.results.side_by_side import Rival, fitted_to
from er_model_lab.results.values import clean, headline
from er_model_lab.results.view import View
from er_model_lab.results.views import views
from er_model_lab.vehicle.ride_forward import RideForward
from er_model_lab.vehicle.ride_problem import ride_as_given
from er_model_lab.verbs.ask import Outcome, Request, provenance, read
from er_model_lab.verbs.compare import beside


def compare(ask: Request) -> Outcome:
    """Simulate each record from its road and duty, starts and road as in `diagnose`, and say where the model fails.

    Raises:
        MissingChannel: Without road or duty, or without any output.
        InputError: When the model has no quarter car.
    """
    model, (records, sealed) = ask.model(), read(ask)
    problem, left = ride_as_given(records, model, sealed)
    floor, data = _white(problem, left, 0), originals(records)
    tables = region_tables(problem, left, ask.seed, noise_at(problem, floor, 0.0 * left))
    result: dict[str, Any] = compare_json(problem, left, floor, 0.0, tables)
    result |= {
        "command": "compare", "level": "vehicle", "model": model.name,
        "explainable": explainable(result["rmse"] ** 2, floor), "channels": _channels(problem, left),
        "preflight": preflight(data, model, model.catalogue).as_json(),
    }  # fmt: skip
    view = View(
        command="compare", model=model.name, headline=headline(result["rmse"], floor), result=clean(result),
        records=views(problem, problem.force - left, None), regions=tables, notes=problem.notes,
        provenance=provenance(records, model, ask),
    )  # fmt: skip
    known = fingerprint(data)
    rivals = [Rival(model, str(ask.model_file), view.records, fitted_to(model, known), tables)]
    for path, other in ask.others():
        own, rest = ride_as_given(records, other, sealed)
        seen = views(own, own.force - rest, None)
        rivals.append(Rival(other, str(path), seen, fitted_to(other, known)))
    view = beside(view, rivals, floor, ask.seed)
    return Outcome(dict(view.result), view, None, problem.complete)


def _white(problem: Problem, left: Array, output: int) -> float:
    """White noise of an output, from what is left of it [N]."""
    part = left[output :: problem.forward.outputs]
    return white_noise([part[i:j] for i, j in itertools.pairwise(problem.motion.starts)])


def _channels(problem: Problem, left: Array) -> dict[str, dict[str, Any]]:
    """Root mean square error of every output in its own unit, and its share of the signal."""
    forward, c = problem.forward, problem.forward.outputs
    assert isinstance(forward, RideForward)
    used, found = problem.used[::c], {}
    for k, name in enumerate(forward.names):
        error, signal = left[k::c][used], problem.force[k::c][used]
        rmse, weight = float(np.sqrt(np.mean(error**2))), float(forward.weights[k])
        found[name] = {
            "unit": CHANNELS[name], "rmse": rmse / weight, "relative": rmse / max(float(np.std(signal)), 1e-300),
            "noise": _white(problem, left, k) / weight,
        }  # fmt: skip
    return found
