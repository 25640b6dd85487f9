"""Every form on the same sampled road, solved by SciPy: what shows that they are one car.

Each form is driven by its own inputs: (2.8) by the road's height, (2.11) and (2.13) by its rate,
the relative form by the rate of the tyre's deflection, (2.19) by the force a fault has taken.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from er_models.forms.descriptor import descriptor_form
from er_models.forms.lipschitz import linearise
from er_models.forms.loss import Factors, lost_force
from er_models.forms.lti import lti_form
from er_models.forms.nlpv import nlpv_form
from er_models.forms.qlpv import qlpv_form
from er_models.forms.relative import relative_form
from er_models.model import Array, Model

SIGNALS = ("deflection", "sprung_acceleration", "unsprung_acceleration", "damper_force")

Rate = Callable[[Array, float, float, float], Array]
"""Rate of a state, from state, duty, height of the road [m] and its rate [m/s]."""


Ride = Callable[[Model, float, Array, Array], Array]
"""`SIGNALS` (n, 4) of a model on a sampled road with a duty."""


def lipschitz(model: Model, dt: float, road: Array, duty: Array) -> Array:
    """`SIGNALS` (n, 4) of the form (2.11) from rest; road (n,) [m], duty (n,) held from each sample on."""
    form = linearise(model)
    states = _solve(lambda x, u, _, w: form.rate(x, u, w), 5, dt, road, duty)
    return np.asarray(states @ np.vstack([np.eye(5)[0], form.C, form.F]).T)


def nlpv(model: Model, dt: float, road: Array, duty: Array) -> Array:
    """The same of the form (2.13)."""
    form = nlpv_form(model)

    def rate(x: Array, u: float, _: float, road_rate: float) -> Array:
        return form.rate(x, u, np.array([road_rate, 0.0, 0.0]))

    states = _solve(rate, 5, dt, road, duty)
    return np.asarray(states @ np.vstack([np.eye(5)[0], form.linear.C, form.linear.F]).T)


def relative(model: Model, dt: float, road: Array, duty: Array) -> Array:
    """The same of the relative form; the tyre that drives it is that of (2.11), solved alongside."""
    form, whole = relative_form(model), linearise(model)

    def rate(y: Array, u: float, _: float, road_rate: float) -> Array:
        tyre = whole.rate(y[:5], u, road_rate)
        return np.concatenate([tyre, form.rate(y[5:], u, tyre[2])])

    states = _solve(rate, 9, dt, road, duty)[:, 5:]
    return np.asarray(states @ np.vstack([np.eye(4)[0], form.C, form.F]).T)


def subsystems(model: Model, dt: float, road: Array, duty: Array) -> Array:
    """The same of (2.8) and (2.10) in a loop."""
    suspension, fluid = lti_form(model), qlpv_form(model)

    def rate(y: Array, u: float, height: float, _: float) -> Array:
        gate = fluid.gate(np.array([y[0] - y[2], y[1] - y[3]]))
        return np.append(suspension.rate(y[:4], y[4], height), fluid.rate(float(y[4]), u, gate))

    states = _solve(rate, 5, dt, road, duty)
    y = np.array([suspension.output(x[:4], x[4], h) for x, h in zip(states, road, strict=True)])
    force = states[:, :4] @ suspension.F + states[:, 4]
    return np.column_stack([y[:, 2], y[:, :2], force])


def descriptor(
    model: Model, dt: float, road: Array, duty: Array, factors: Factors
) -> tuple[Array, Array]:
    """The same of (2.19) with a fault, F_d - f being the force left; and the lost force f (n,) [N]."""
    form, healthy = descriptor_form(model), linearise(model)

    def rate(x: Array, u: float, _: float, road_rate: float) -> Array:
        return form.side(np.append(x, lost_force(healthy, x, factors)), u, road_rate)

    states = _solve(rate, 5, dt, road, duty)
    f = np.array([lost_force(healthy, x, factors) for x in states])
    rows = np.vstack([np.eye(6)[0], form.C, form.F])
    return np.column_stack([states, f]) @ rows.T, f


def _solve(rate: Rate, n: int, dt: float, road: Array, duty: Array) -> Array:
    """States (samples, n) from rest, the road a straight line between samples, the duty held."""
    x, out = np.zeros(n), np.empty((road.size, n))
    for k in range(road.size):
        out[k] = x
        if k + 1 == road.size:
            break
        slope, height, u = float(road[k + 1] - road[k]) / dt, float(road[k]), float(duty[k])

        def within(s: float, y: Array, u: float = u, h: float = height, w: float = slope) -> Array:
            return rate(y, u, h + w * s, w)

        x = solve_ivp(within, (0.0, dt), x, method="LSODA", rtol=1e-8, atol=1e-11).y[:, -1]
    return out
