"""Reference solutions by SciPy, adaptive and at high accuracy, and derivatives of a whole model by its parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from er_models.kernel.load import kernel
from er_models.kernel.rows import ROWS, W0, W
from er_models.model import Array, Model
from er_models.prediction import Motion
from er_models.rhs import damper_rate, vehicle_point, vehicle_points
from er_models.sensitivity import Rows, quotients, steps
from scipy.integrate import solve_ivp

Signal = Callable[[float, int], Array]


def first_states(model: Model, inputs: Motion) -> Array:
    """Where the states of a record begin."""
    c = model.compiled()
    s = np.empty((ROWS, c.at_rest.shape[0]))
    kernel(model.catalogue).settle_point(
        c.on,
        c.slots,
        c.links,
        c.at_rest,
        c.p,
        s,
        inputs.x[0],
        inputs.v[0],
        inputs.a[0],
        inputs.u[0],
        0.0,
    )
    return s[W].copy()


def vehicle_rate(
    model: Model, q: Array, w: Array, u: float, road_rate: float, t: float = 0.0
) -> tuple[Array, Array, Array]:
    """Rates of the mechanical state (4,) and damper states (n_states,), and outputs a_s, a_us, F_d."""
    dq, dw, out = vehicle_point(model, q, w, u, road_rate, t)
    return dq, dw, out[:3].copy()


def measured(model: Model, w: Array, x: float, v: float, a: float, u: float, t: float) -> float:
    """Measured force [N] in the states w (n_states,)."""
    c, s = model.compiled(), np.zeros((ROWS, w.shape[0]))
    s[W], s[W0] = w, w
    point = kernel(model.catalogue).damper_point
    return float(point(c.on, c.links, c.p, s, x, v, a, float(u), float(t), 0.0)[1])


def damper_force(model: Model, inputs: Motion, signal: Signal) -> Array:
    """Measured force [N] (n,) along a smooth motion x = signal(t, 0), v = signal(t, 1), a = signal(t, 2).

    The duty is that of the record, held. `damper_rate` is the right-hand side; no dead time, no force delay.
    """
    slots = [s for s in model.compiled().slots if _has_equation(model, int(s))]
    w, out = first_states(model, inputs), np.empty(inputs.n)

    def motion_at(t: float) -> tuple[float, float, float]:
        return float(signal(t, 0)), float(signal(t, 1)), float(signal(t, 2))

    for k, (t, u) in enumerate(zip(inputs.t, inputs.u)):
        out[k] = measured(model, w, *motion_at(t), u, t)

        def rate(s: float, y: Array, u: float = u, w: Array = w) -> Array:
            state = w.copy()
            state[slots] = y
            return damper_rate(model, state, *motion_at(s), u, s)[0][slots]

        if k + 1 < inputs.n and slots:
            w = w.copy()
            w[slots] = solve_ivp(
                rate, (t, t + inputs.dt), w[slots], method="LSODA", rtol=1e-8, atol=1e-11
            ).y[:, -1]
    return out


def _has_equation(model: Model, slot: int) -> bool:
    """Whether a slot holds a state, not the yield force of a model without response time."""
    return model.has_response or slot != model.catalogue.slots["response"]


def vehicle_run(model: Model, dt: float, road: Array, duty: Array) -> tuple[Array, Array]:
    """Mechanical states (n, 4) and damper force [N] (n,) of the quarter car from rest."""
    n_states, point = model.catalogue.n_states, vehicle_points(model)
    slots = model.compiled(plant=True).slots
    y, n = np.zeros(4 + n_states), road.shape[0]
    states, force = np.empty((n, 4)), np.empty(n)
    for k in range(n):
        slope = (road[k + 1] - road[k]) / dt if k + 1 < n else 0.0
        states[k] = y[:4]
        force[k] = point(y[:4], y[4:], duty[k], slope, k * dt)[2][2]

        def rate(t: float, z: Array, u: float = duty[k], slope: float = slope) -> Array:
            w = np.zeros(n_states)
            w[slots] = z[4:]
            dq, dw, _ = point(z[:4], w, u, slope, t)
            return np.concatenate([dq, dw[slots]])

        if k + 1 < n:
            z = np.concatenate([y[:4], y[4:][slots]])
            end = solve_ivp(
                rate, (k * dt, (k + 1) * dt), z, method="LSODA", rtol=1e-8, atol=1e-11
            ).y[:, -1]
            y[:4], y[4 + np.asarray(slots)] = end[:4], end[4:]
    return states, force


def sensitivities(
    model: Model, parameters: Sequence[tuple[str, str]], rows: Rows
) -> tuple[Array, Array]:
    """Outputs (n,) of a model and their derivatives (n, p) by parameters (effect, name) [per SI unit].

    rows: outputs (m, n) of flat parameter vectors (m, n_parameters), `predict_many` or many simulations.
    """
    c, base = model.catalogue, model.compiled().p
    known = [c[effect].parameter(name) for effect, name in parameters]
    columns = np.array([c.column(*q) for q in parameters], int)
    scale = np.array([model.scales.of(q.unit) for q in known])
    at = base[columns]

    def outputs(points: Array) -> Array:
        vectors = np.tile(base, (points.shape[0], 1))
        vectors[:, columns] = points
        return rows(vectors)

    here = rows(base[None])[0]
    return here, quotients(outputs, at, steps(known, at / scale) * scale, here)
