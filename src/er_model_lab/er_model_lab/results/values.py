"""What all results share: numbers that JSON can hold, parameters with their units, the headline."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from er_models.model import Model


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


def headline(rmse: float, floor: float) -> str:
    """One line in newtons: what is unexplained, what of it is noise, what is the model's."""
    model = math.sqrt(max(rmse**2 - floor**2, 0.0))
    return f"unexplained {rmse:.3g} N, noise {floor:.3g} N, model {model:.3g} N"
