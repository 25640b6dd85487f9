"""The right-hand side and the outputs of a vehicle model in the thesis's state."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from er_models.errors import InputError
from er_models.model import Array, Model
from er_models.rhs import vehicle_points

STATES = ("z_def", "v_s", "z_us - z_r", "v_us", "f_y")
NAMES = (*(f"d({s})/dt" for s in STATES), "sprung acceleration", "unsprung", "F_d")
"""Names of the eight values."""

Rates = Callable[[Array, float, float], Array]
"""Rates (5,), both accelerations and F_d, (8,), of state (5,), duty and road rate [m/s]."""


def rates_of(model: Model, loss: float = 0.0, others: float = 0.0, t: float = 0.0) -> Rates:
    """The equations (2.5), or (2.18) where the damper has lost the force `loss` [N].

    The loss enters where every damper force does: as the constant force of `preload`, against it.
    others: value of every state but the five [SI]; t: time since the record began [s]; a model
    that is one of the forms answers to neither. The accelerations are those reported.
    """
    check_parts(model)
    if loss:
        model = model.with_effect("preload", {"F_0": -loss})
    slot, point = model.catalogue.slots["response"], vehicle_points(model)

    def rates(x: Array, u: float, road_rate: float) -> Array:
        w = np.full(model.catalogue.n_states, others)
        w[slot] = x[4]
        dq, dw, out = point(np.ascontiguousarray(x[:4]), w, u, road_rate, t)
        return np.concatenate([dq, [dw[slot]], out[4:], [out[2]]])

    return rates


def sizes_of(model: Model) -> Array:
    """Steps for difference quotients of the state (5,), from the envelope of the model."""
    s = model.scales
    return np.array([s.deflection, s.velocity, 0.1 * s.deflection, s.velocity, s.force])


def envelope_of(model: Model) -> Array:
    """Sizes of the state (5,) within which a form must hold: the tyre may leave the road."""
    s = model.scales
    return np.array([s.deflection, s.velocity, s.deflection, s.velocity, s.force])


def check_parts(model: Model) -> None:
    """Raise `InputError` for a model without the parts the forms are about."""
    for part in ("quarter_car", "response"):
        if part not in model.effects:
            varying = [n for n in model.effects if "response_time" in model.catalogue[n].hooks]
            expected = "a vehicle model with a constant response time"
            found = ", ".join(varying) if part == "response" and varying else "nothing"
            raise InputError(model.name, f"effects.{part}", expected, found)
    tau = model.value("response", "tau")
    if not tau > 0.0:
        raise InputError(model.name, "effects.response.tau", "a value above 0 s", tau)
