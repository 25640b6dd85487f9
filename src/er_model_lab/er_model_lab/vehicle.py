"""Comparison at the level of the vehicle: force and motion predicted from road and duty alone."""

from __future__ import annotations

from typing import Any

import numpy as np
from er_models.model import Array, Model
from er_models.simulate import simulate
from scipy.optimize import least_squares

from er_model_lab.commands import Outcome, Request, beside, provenance, read
from er_model_lab.load import fingerprint
from er_model_lab.preflight.check import preflight
from er_model_lab.prepare import WARM_UP, white_noise
from er_model_lab.present import clean, headline
from er_model_lab.record import Record
from er_model_lab.side_by_side import Rival, fitted_to
from er_model_lab.view import RecordView, View

OUTPUTS = ("damper_force", "deflection", "sprung_acceleration", "unsprung_acceleration")


def compare(ask: Request) -> Outcome:
    """Simulate each record from its road and duty, with its unknown initial state estimated.

    Raises:
        MissingChannel: Without road, duty or damper_force.
        InputError: When the model has no quarter car.
    """
    model, (records, _) = ask.model(), read(ask)
    runs = [(r, _predict(model, r)) for r in records]
    by_channel = {name: _rms(runs, name) for name in OUTPUTS}
    force = by_channel["damper_force"]
    measured = np.concatenate([r.need("damper_force", "to compare")[_scored(r)] for r, _ in runs])
    floor = white_noise([np.asarray(r.need("damper_force", "to compare")) for r, _ in runs])
    rmse = float(force["rmse"])
    result: dict[str, Any] = {
        "command": "compare", "level": "vehicle", "model": model.name, "rmse": rmse,
        "nrmse": rmse / float(np.ptp(measured)), "noise_floor": floor,
        "explainable": max(1.0 - floor**2 / rmse**2, 0.0), "worst": [], "channels": by_channel,
        "rmse_by_record": {r.name: _rms([(r, p)], "damper_force")["rmse"] for r, p in runs},
        "preflight": preflight(records, model, model.catalogue).as_json(),
        "notes": [n for r, _ in runs for n in r.notes], "complete": all(r.complete for r, _ in runs),
    }  # fmt: skip
    view = View(
        command="compare", model=model.name, headline=headline(rmse, floor), result=clean(result),
        records=tuple(_view(r, p) for r, p in runs), notes=tuple(result["notes"]),
        provenance=provenance(records, model, ask),
    )  # fmt: skip
    data = fingerprint(records)
    rivals = [Rival(model, str(ask.model_file), view.records, fitted_to(model, data))]
    for path, other in ask.others():
        seen = tuple(_view(r, _predict(other, r)) for r in records)
        rivals.append(Rival(other, str(path), seen, fitted_to(other, data)))
    view = beside(view, rivals, floor, ask.seed)
    return Outcome(dict(view.result), view, None, bool(result["complete"]))


def _predict(model: Model, record: Record) -> dict[str, Array]:
    """Simulated channels of a record; the initial state (4,) is fitted on its first half second."""
    road = record.need("road", "to simulate the vehicle")
    duty = record.need("duty", "to simulate the vehicle")
    record.need("damper_force", "to compare")
    n = min(len(record), max(int(0.5 / record.dt), 20))
    channels = [c for c in OUTPUTS if record.has(c)]
    size = {c: max(float(np.std(record.channels[c])), 1e-12) for c in channels}

    def misfit(q: Array) -> Array:
        run = simulate(model, record.dt, road[:n], duty[:n], q * scale)
        return np.concatenate([(run[c] - record.channels[c][:n]) / size[c] for c in channels])

    s = model.scales
    scale = np.array([s.deflection, s.velocity, s.deflection, s.velocity])
    start = least_squares(misfit, np.zeros(4), diff_step=1e-4, max_nfev=15).x
    return simulate(model, record.dt, road, duty, start * scale)


def _scored(record: Record) -> slice:
    """Samples that count: after the warm-up."""
    return slice(int(WARM_UP / record.dt), None)


def _rms(runs: list[tuple[Record, dict[str, Array]]], channel: str) -> dict[str, float]:
    """Root mean square error of one channel over all records that have it, and its share of the signal."""
    pairs = [(r.channels[channel], p[channel], _scored(r)) for r, p in runs if r.has(channel)]
    if not pairs:
        return {"rmse": float("nan"), "relative": float("nan")}
    error = np.concatenate([(a - b)[s] for a, b, s in pairs])
    signal = np.concatenate([a[s] for a, _, s in pairs])
    rmse = float(np.sqrt(np.mean(error**2)))
    return {"rmse": rmse, "relative": rmse / max(float(np.std(signal)), 1e-300)}


def _view(record: Record, run: dict[str, Array]) -> RecordView:
    """Measured and simulated force of a record."""
    scored = np.zeros(len(record), bool)
    scored[_scored(record)] = True
    return RecordView(
        record.name, record.t - record.t[0], run["deflection"], run["deflection_velocity"], run["duty"],
        record.channels["damper_force"], run["damper_force"], None, scored, np.zeros(len(record), bool),
    )  # fmt: skip
