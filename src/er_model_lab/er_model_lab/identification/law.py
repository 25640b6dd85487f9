"""The response time as a function of the duty: from a table of levels to the parameters of a model, (1.21)."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from er_models.effect import Effect
from er_models.model import Array, Model
from er_models.sensitivity import steps

from er_model_lab.fitting.fit import Box
from er_model_lab.identification.levels import Table
from er_model_lab.problem.forward import Free
from er_model_lab.problem.problem import Problem


@dataclass(frozen=True)
class Quadratic:
    """tau(u) = tau_0 + tau_1 u + tau_2 u^2 through a table (1.21).

    value (3,), covariance (3, 3); chi2: weighted squares that are left, over `freedom` degrees of freedom.
    """

    value: Array
    covariance: Array
    chi2: float
    freedom: int


def quadratic(table: Table) -> Quadratic | None:
    """Weighted least squares of the quadratic (1.21); None for fewer than three levels or without deviations."""
    if (
        table.duty.size < 3
        or not np.all(np.isfinite(table.covariance))
        or not np.all(table.sd > 0)
    ):
        return None
    basis = np.vander(table.duty, 3, increasing=True)
    weight = np.linalg.pinv(table.covariance, rcond=1e-12)
    spread = np.asarray(np.linalg.pinv(basis.T @ weight @ basis, rcond=1e-14), float)
    value = spread @ basis.T @ weight @ table.tau
    left = table.tau - basis @ value
    return Quadratic(value, spread, float(left @ weight @ left), table.duty.size - 3)


def response_time(model: Model, duty: Array) -> Array:
    """Response time (m,) [s] of a model at constant duties (m,), from the equations of its effects."""
    total, scale = np.zeros(duty.size), np.ones(duty.size)
    for name, values in model.effects.items():
        effect = model.catalogue[name]
        if "response_time" in effect.hooks:
            total += _at(effect, "response_time", values, duty)
        if "tau_scale" in effect.hooks and _depends_on_duty_alone(effect):
            scale *= _at(effect, "tau_scale", values, duty)
    return np.asarray(total * scale)


def follow_table(model: Model, response: Free, table: Table, problem: Problem) -> Model:
    """The model with its response parameters fitted to a table; what the table leaves open stays as it is.

    Weighted Gauss-Newton steps of least norm inside the bounds.
    """
    known = tuple(q for q in response if _depends_on_duty_alone(model.catalogue[q[0]]))
    if not known:
        return model
    box = Box(model, known, problem.scales)
    weight = _weights(table, 1e-3 * problem.motion.dt)
    theta = box.start()
    for _ in range(10):
        now = response_time(box.model_at(theta), table.duty)
        step = steps(box.parameters, theta)
        slopes = [
            (response_time(box.model_at(theta + d), table.duty) - now) / d.sum()
            for d in np.diag(step)
        ]
        change = (np.array(slopes).T * box.size) * weight[:, None]
        wanted = (table.tau - now) * weight
        move = np.linalg.lstsq(change, wanted, rcond=1e-9)[0]
        theta = np.clip(theta + move * box.size, box.low, box.high)
    return box.model_at(theta)


def _weights(table: Table, least: float) -> Array:
    """One over the deviations (m,), of `least` [s] each or more; 0 for a level without one, alike if none has one."""
    known = np.isfinite(table.sd)
    if not known.any():
        return np.full(table.sd.size, 1.0 / least)
    return np.where(known, 1.0 / np.maximum(np.where(known, table.sd, 1.0), least), 0.0)


def _depends_on_duty_alone(effect: Effect) -> bool:
    """Whether the response time it gives or scales needs no signal but the duty."""
    return all(
        set(inspect.signature(effect.hooks[hook]).parameters) <= {*effect.names, "u"}
        for hook in ("response_time", "tau_scale")
        if hook in effect.hooks
    )


def _at(effect: Effect, hook: str, values: Mapping[str, float], duty: Array) -> Array:
    """Value of a hook at constant duties (m,)."""
    function = effect.hooks[hook]
    names = inspect.signature(function).parameters
    found = []
    for u in duty:
        given = {**values, "u": float(u)}
        found.append(float(function(**{n: given[n] for n in names})))  # type: ignore[arg-type]
    return np.asarray(found)
