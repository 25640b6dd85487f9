"""A start model of a kind, scaled to data: effects, coefficients by least squares, the rig as far as they reach."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from er_models.errors import InputError, UnknownName
from er_models.model import Array, Model
from er_models.prediction import Motion, motion, predict
from er_models.scales import Scales, peak
from er_records.record import Record
from scipy.optimize import lsq_linear

from er_model_lab.fitting.kinds import KINDS
from er_model_lab.fitting.rig import rig_of

LINEAR = ("N", "N/m", "N s/m", "N/duty")
"""Units of coefficients that the force is linear in."""
MOST = 40_000
"""Samples that coefficients are found on."""
CONSTANT, GAS = "preload", 0.3
"""The effect that a gas force adds to any kind, and the share of the moving force from which on it does."""
FAR = 2.0
"""Constant force over the one that moves beyond which no bound allows it: a weight, or a pressure."""
STARTS = 2
"""Sets of starting values of the other parameters that are tried."""


def start_model(records: Sequence[Record], kind: str, name: str) -> Model:
    """The start model of a kind for these records; they may lack a duty, which then counts as 0.

    Raises:
        UnknownName: No such kind.
        MissingChannel: No force or no deflection.
    """
    if kind not in KINDS:
        raise UnknownName("kind", kind, tuple(KINDS))
    parts = [_part(r) for r in records]
    forces = [r.need("damper_force", "to scale the model") for r in records]
    force = np.concatenate(forces)
    x, v, u = (np.concatenate([getattr(m, k) for m in parts]) for k in ("x", "v", "u"))
    largest = float(u.max())
    duty = largest if largest > 0.0 else 1.0  # without a field nobody knows how far it would go
    scales = Scales(peak(force), peak(x), peak(v), duty)
    if not (np.ptp(x) > 0.0 and np.ptp(force) > 0.0):
        raise InputError(records[0].source, "deflection", "a damper that moves", "a standstill")
    _check_offset(records[0], force, scales)
    driven = any(r.has("duty") for r in records)
    source = f"lab new: {kind}, scaled to {', '.join(r.name for r in records[:4])}"
    source += f" and {len(records) - 4} more records" * (len(records) > 4)
    source += "" if driven else ", without a duty"
    begun = Model(name, {}, scales, source, rig=rig_of(x, v, u if driven else None))
    constant = abs(float(np.median(force))) > GAS * scales.force
    effects = (*KINDS[kind].effects, *[CONSTANT] * constant)
    made = [_solved(_begun(begun, effects, which), parts, forces) for which in range(STARTS)]
    return min(made, key=lambda each: each[1])[0]


def _begun(model: Model, effects: Sequence[str], which: int) -> Model:
    """A model of effects with one of the sets of starting values."""
    for effect in effects:
        found = model.catalogue[effect].parameters
        model = model.with_effect(
            effect, {q.name: model.start(effect, q.name, which) for q in found}
        )
    return model


def _check_offset(record: Record, force: Array, scales: Scales) -> None:
    """Refuse a constant force beside which the one that moves is nothing."""
    constant = float(np.median(force))
    if abs(constant) > FAR * scales.force:
        found = f"{constant:.4g} N always there, and {scales.force:.3g} N that moves"
        said = f"take it off in names.yaml: damper_force: {{from: ..., offset: {-constant:.4g}}}"
        raise InputError(record.source, "damper_force", "a force about zero", found, said)


def _part(record: Record) -> Motion:
    """The motion of a record, the duty 0 where it has none."""
    x = record.need("deflection", "to scale the model")
    v = record.need("deflection_velocity", "to scale the model")
    u = record.channels.get("duty", np.zeros(x.size))
    return motion(record.dt, x, v, u)


def _solved(model: Model, parts: Sequence[Motion], forces: Sequence[Array]) -> tuple[Model, float]:
    """The model with the coefficients that fit best within their bounds, and its rms error [N]."""
    free = [
        (e, q) for e in model.effects for q in model.catalogue[e].parameters
        if q.unit in LINEAR and q.neutral == 0.0 and q.fitted
    ]  # fmt: skip
    bare = model
    for e, q in free:
        bare = _with(bare, e, q.name, 0.0)
    step = max(1, sum(f.size for f in forces) // MOST)
    force = np.concatenate(forces)[::step]

    def along(one: Model) -> Array:
        return np.concatenate([predict(one, m) for m in parts])[::step]

    columns = [along(_with(bare, e, q.name, model.value(e, q.name))) for e, q in free]
    units = np.array([model.value(e, q.name) for e, q in free])
    bounds = np.array([model.bounds(e, q.name) for e, q in free]).T / units
    found = lsq_linear(np.column_stack(columns), force, bounds=(bounds[0], bounds[1]))
    for (e, q), factor, unit in zip(free, found.x, units, strict=True):
        model = _with(model, e, q.name, float(factor * unit))
    return model, float(np.sqrt(np.mean((along(model) - force) ** 2)))


def _with(model: Model, effect: str, name: str, value: float) -> Model:
    """The model with one value changed."""
    return replace(
        model, effects={**model.effects, effect: {**model.effects[effect], name: value}}
    )
