"""Errors of the measured velocity, undone before the motion is fused, and put back into the model that is written."""

from __future__ import annotations

from dataclasses import replace

from er_models.model import Model
from er_records.dataset import Dataset
from er_records.record import Record

from er_model_lab.fitting.fit import Fit

KINEMATIC = ("velocity_lag", "velocity_gain")
"""Errors of the velocity channel that are undone before the motion is fused."""


def known_lag(model: Model) -> float | None:
    """Lag of the velocity channel the model already holds [s]."""
    return model.value("velocity_lag", "T_v") if "velocity_lag" in model.effects else None


def on_fused(model: Model) -> Model:
    """The model without lag and gain of the velocity channel, for a motion in which they are undone."""
    for name in KINEMATIC:
        model = model.without_effect(name) if name in model.effects else model
    return model


def as_searched(fitted: Fit) -> Model:
    """The model of a fit as it was fitted: without what was undone before, with a lag that the force itself showed."""
    free = {effect for effect, _ in fitted.free}
    return put_back(on_fused(fitted.model), fitted.model, only=free)


def put_back(found: Model, given: Model, only: set[str] | None = None) -> Model:
    """A model with lag and gain of the velocity channel as a given one has them; only: of these effects."""
    for name in KINEMATIC:
        if name not in given.effects or (only is not None and name not in only):
            continue
        found = found.with_effect(name, dict(given.effects[name]))
        if name in given.deviations:
            deviations = {**found.deviations, name: given.deviations[name]}
            found = replace(found, deviations=deviations)
    return found


def restored(fitted: Fit, given: Model) -> Fit:
    """A fit whose model has lag and gain of the velocity channel as a given one has them."""
    return replace(fitted, model=put_back(fitted.model, given))


def in_scale(data: Dataset, model: Model) -> Dataset:
    """The data with the gain of a measured velocity channel undone, where the model holds one."""
    if "velocity_gain" not in model.effects:
        return data
    gain, name = model.value("velocity_gain", "g_v"), "deflection_velocity"

    def scaled(r: Record) -> Record:
        if not r.has(name) or name in r.derived:
            return r
        return replace(r, channels={**r.channels, name: r.channels[name] / gain})

    return data.mapped(scaled)
