"""What all results share: numbers that JSON can hold, parameters with their units, the headline."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from er_models.effect import Param
from er_models.model import Model

from er_model_lab.problem.forward import Limits

EXACT = 1e-6
"""Share [1] of a bound within which a value is at it: a fit ends there to the last digits, or not at all."""


def clean(value: Any) -> Any:
    """JSON without infinities and NaN: they become null."""
    if isinstance(value, Mapping):
        return {str(k): clean(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [clean(v) for v in value]
    if isinstance(value, float | np.floating):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, np.integer):
        return int(value)
    return value


def parameters(model: Model, effect: str) -> dict[str, list[Any]]:
    """Values of an effect: {name: [value, standard deviation, unit]}."""
    out = {}
    for q in model.catalogue[effect].parameters:
        sd = model.deviations.get(effect, {}).get(q.name, float("inf"))
        out[q.name] = [float(model.effects[effect][q.name]), float(sd), q.unit]
    return out


def estimates(before: Model, after: Model, limits: Limits) -> dict[str, dict[str, dict[str, Any]]]:
    """Every parameter of a model with its value before (None where it is new), deviation, bounds and unit.

    limits: bounds [SI] that the fit kept to in place of the catalogue's. status: given (not fitted), added, at_bound,
    not_identified (the data do not determine it: its deviation is as large as such a value is) or identified.
    """
    return {
        effect: {
            q.name: _estimate(before, after, effect, q, limits)
            for q in after.catalogue[effect].parameters
        }
        for effect in after.effects
    }


def _estimate(
    before: Model, after: Model, effect: str, q: Param, limits: Limits
) -> dict[str, Any]:
    """One parameter; an additive effect of size 0 is not called bounded."""
    value = float(after.effects[effect][q.name])
    low, high = limits.get((effect, q.name)) or after.bounds(effect, q.name)
    sd = after.deviations.get(effect, {}).get(q.name)
    known = effect in before.effects
    at = [math.isclose(value, end, rel_tol=EXACT) for end in (low, high)]
    bounded = at[1] or (at[0] and not low == q.neutral == 0.0)
    least = max(abs(value), after.scales.of(q.unit) * q.size)
    status = (
        "given" if sd is None and known else "at_bound" if bounded
        else "not_identified" if sd is None or not sd < least else "identified" if known else "added"
    )  # fmt: skip
    return {
        "value": value, "sd": sd, "unit": q.unit, "before": float(before.effects[effect][q.name]) if known else None,
        "bounds": [low, high], "status": status,
    }  # fmt: skip


def headline(rmse: float, floor: float) -> str:
    """One line in newtons: what is unexplained, what of it is noise, what is the model's."""
    model = math.sqrt(max(rmse**2 - floor**2, 0.0))
    return f"unexplained {rmse:.3g} N, noise {floor:.3g} N, model {model:.3g} N"
