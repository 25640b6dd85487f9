"""The same equations by SciPy: hooks as plain Python, one interval of constant inputs after another."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from er_models.catalogue import CATALOGUE
from er_models.model import Array, Model
from er_models.prediction import Motion
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline

TIGHT = 1e-9
"""Tolerance of what counts as exact."""
LOOSE = tuple(10.0 ** (-0.5 * i) for i in range(2, 19))
"""Tolerances that are tried, loosest first."""


def yield_force(model: Model) -> Callable[[float, float, float, float], float]:
    """Rate of the yield force of the dynamic Guo damper, of x, v, u and itself."""
    target: Any = CATALOGUE["guo_yield"].hooks["target"]
    relax: Any = CATALOGUE["response"].hooks["relax"]
    gate, tau = model.effects["guo_yield"], model.value("response", "tau")

    def slope(x: float, v: float, u: float, f_y: float) -> float:
        rate, asked = relax(tau_y=tau, tau_scale=1.0, y=target(**gate, x=x, v=v, u=u))
        return float(asked - rate * f_y)

    return slope


Interpolant = Callable[[Array, Array, float], Callable[[float], float]]
"""From values and slopes at samples of a distance [s] to a function of time."""


def splined(y: Array, d: Array, dt: float) -> Callable[[float], float]:
    """SciPy's own cubic."""
    spline = CubicHermiteSpline(np.arange(y.size) * dt, y, d)
    return lambda t: float(spline(t))


def cubics(y: Array, d: Array, dt: float) -> Callable[[float], float]:
    """The same, as fast as plain Python can."""
    rise, e0, e1 = np.diff(y), dt * d[:-1], dt * d[1:]
    rows = list(
        zip(*(c.tolist() for c in (y[:-1], e0, 3 * rise - 2 * e0 - e1, e0 + e1 - 2 * rise)))
    )
    last = len(rows) - 1

    def at(t: float) -> float:
        s = t / dt
        k = min(int(s), last)
        a, b, c, d = rows[k]
        s -= k
        return float(a + s * (b + s * (c + s * d)))

    return at


def scipy_force(
    model: Model, inputs: Motion, rtol: float, interpolant: Interpolant = cubics
) -> Array:
    """Force (n,) of the dynamic Guo damper along one record."""
    p, dt = model.effects["passive"], inputs.dt
    x_of, v_of = interpolant(inputs.x, inputs.v, dt), interpolant(inputs.v, inputs.a, dt)
    slope = yield_force(model)
    target: Any = CATALOGUE["guo_yield"].hooks["target"]
    w = float(target(**model.effects["guo_yield"], x=inputs.x[0], v=inputs.v[0], u=inputs.u[0]))
    f_y, grid = np.empty(inputs.n), inputs.t
    edges = sorted({0, inputs.n - 1, *(int(k) + 1 for k in np.flatnonzero(np.diff(inputs.u)))})
    for i, j in pairwise(edges):
        u, times = float(inputs.u[i]), grid[i : j + 1]
        f_y[i : j + 1] = solve_ivp(
            lambda t, y, u=u: [slope(x_of(t), v_of(t), u, y[0])], (times[0], times[-1]), [w], "LSODA",
            t_eval=times, rtol=rtol, atol=rtol,
        ).y[0]  # fmt: skip
        w = float(f_y[j])
    return np.asarray(p["k0"] * inputs.x + p["c0"] * inputs.v + f_y)


def scipy_ride(model: Model, dt: float, road: Array, duty: Array, rtol: float) -> Array:
    """Damper force (n,) of the quarter car from rest; the road is straight and the duty held between samples."""
    p, c = model.effects["passive"], model.effects["quarter_car"]
    slope, n = yield_force(model), road.shape[0]
    size = np.array([model.scales.deflection, model.scales.velocity] * 2 + [model.scales.force])

    def rate(_t: float, y: Array, u: float, road_rate: float) -> list[float]:
        x, v_s, z_t, v_us, f_y = y.tolist()
        v = v_s - v_us
        force = c["k_s"] * x + p["k0"] * x + p["c0"] * v + f_y
        ahead = (force - c["k_t"] * z_t) / c["m_us"]
        return [v, -force / c["m_s"], v_us - road_rate, ahead, slope(x, v, u, f_y)]

    y, out = np.zeros(5), np.empty(n)
    for k in range(n):
        out[k] = p["k0"] * y[0] + p["c0"] * (y[1] - y[3]) + y[4]
        if k + 1 < n:
            args = (float(duty[k]), float(road[k + 1] - road[k]) / dt)
            y = solve_ivp(rate, (0.0, dt), y, "LSODA", args=args, rtol=rtol, atol=rtol * size).y[
                :, -1
            ]
    return out


def as_exact(run: Callable[[float], Array], exact: Array, error: float) -> float:
    """Loosest tolerance at which the largest error of a run is no more than this."""
    fits = (r for r in LOOSE if np.abs(run(r) - exact).max() <= error)
    return float(next(fits, TIGHT))
