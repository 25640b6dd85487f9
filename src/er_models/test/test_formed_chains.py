"""What the field does by chains follows the field with the response time of the yield force, in closed form."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from er_models.catalogue import CATALOGUE
from er_models.model import Array, Model
from er_models.prediction import motion, predict
from er_models.simulation import simulate
from models_help import DT, SMALL, car, guo, span
from reference import vehicle_run

Values = Mapping[str, Mapping[str, float]]

TAU, V = 0.02, 0.1
LOW, HIGH, UP, DOWN, N = 0.1, 0.3, 5, 25, 45
"""Duty from sample UP on to sample DOWN, before and after it, and samples."""
T = np.arange(N) * DT
DUTY = np.where((np.arange(N) >= UP) & (np.arange(N) < DOWN), HIGH, LOW)

CHAINS: dict[str, tuple[Mapping[str, float], Array]] = {
    "field_viscosity": ({"c_u": 100.0}, np.full(N, 100.0 * V)),
    "field_stiffness": ({"k_u": 1000.0}, 1000.0 * V * T),
    "field_preload": ({"F_u": 10.0}, np.full(N, 10.0)),
    "field_friction": ({"F_u": 10.0, "v_0": 0.005}, np.full(N, 10.0)),
    "bouc_wen_hysteresis": ({"F_h": 0.0, "F_u": 10.0, "z_y": 1e-3}, np.full(N, 10.0)),
}
"""Parameters, and the force [N] per formed duty at a constant velocity V from x = 0."""


def formed(rise: float, fall: float, later: float = 0.0) -> Array:
    """Duty whose chains have formed, with a time constant [s] up and another down, after a dead time [s]."""
    up, down = T - UP * DT - later, T - DOWN * DT - later
    top = LOW + (HIGH - LOW) * (1.0 - np.exp(-np.maximum(up, 0.0) / rise))
    peak = LOW + (HIGH - LOW) * (1.0 - np.exp(-(DOWN - UP) * DT / rise))
    fallen = LOW + (peak - LOW) * np.exp(-np.maximum(down, 0.0) / fall)
    return np.where(down > 0.0, fallen, top)


def two_lags(first: float) -> Array:
    """The same behind an amplifier's lag [s]: each step an exponential of an exponential."""

    def step(t: Array) -> Array:
        t = np.maximum(t, 0.0)
        slow, fast = TAU * np.exp(-t / TAU), first * np.exp(-t / first)
        return 1.0 - (slow - fast) / (TAU - first)

    return LOW + (HIGH - LOW) * (step(T - UP * DT) - step(T - DOWN * DT))


def force(effects: Values) -> Array:
    """Force [N] (N,) at the constant velocity."""
    return predict(Model("chains", effects, SMALL), motion(DT, V * T, V + 0.0 * T, DUTY, 0.0 * T))


LAGS: dict[str, tuple[Values, Array]] = {
    "response": ({"response": {"tau": TAU}}, formed(TAU, TAU)),
    "static": ({}, DUTY),
    "dead_time": (
        {"response": {"tau": TAU}, "dead_time": {"T_d": 0.012}},
        formed(TAU, TAU, 0.012),
    ),
    "varying_time_constant": (
        {"response": {"tau": TAU}, "varying_time_constant": {"g": 2.0, "h": 5.0}},
        formed(TAU * (1.0 + 2.0 * HIGH + 5.0 * HIGH**2), TAU * (1.0 + 2.0 * LOW + 5.0 * LOW**2)),
    ),
    "response_quadratic": (
        {"response_quadratic": {"tau_0": 0.01, "tau_1": 0.05, "tau_2": 0.1}},
        formed(0.034, 0.016),
    ),
    "amplifier_lag": ({"response": {"tau": TAU}, "amplifier_lag": {"T_a": 0.01}}, two_lags(0.01)),
}


@pytest.mark.parametrize("lag", LAGS)
@pytest.mark.parametrize("name", CHAINS)
def test_follows_the_duty_as_the_yield_force_does(name: str, lag: str) -> None:
    values, per_duty = CHAINS[name]
    effects, u_f = LAGS[lag]
    close = (
        1e-3 if lag == "amplifier_lag" else 1e-7
    )  # its exponential is taken as straight in each step
    assert force({**effects, name: values}) == pytest.approx(per_duty * u_f, rel=close, abs=1e-9)


def test_falls_faster_than_it_forms() -> None:
    """The factor on the fall is r but for the share by which it passes into that of the rise, at most a tenth."""
    slower = {"response": {"tau": TAU}, "rise_fall_asymmetry": {"r": 0.4}}
    found = force({**slower, "field_viscosity": {"c_u": 1.0 / V}})
    assert np.abs(found - formed(TAU, 0.4 * TAU)).max() < 0.02 * HIGH
    assert np.abs(found - formed(TAU, TAU)).max() > 0.2 * HIGH


def test_in_the_car_against_scipy() -> None:
    model = car().with_effect("field_viscosity", {"c_u": 100.0})
    model = model.with_effect("rise_fall_asymmetry", {"r": 0.5})
    n = 81
    road, duty = 0.004 * np.sin(30.0 * np.arange(n) * DT), np.repeat([0.0, 0.3, 0.1], 27)
    states, exact = vehicle_run(model, DT, road, duty)
    run = simulate(model, DT, road, duty)
    assert np.abs(run["damper_force"] - exact).max() < 1e-3 * span(exact)
    assert np.abs(run["deflection"] - states[:, 0]).max() < 1e-3 * span(states[:, 0])


def test_only_models_with_chains_carry_their_state() -> None:
    plain, static = guo(), guo().without_effect("response")
    assert CATALOGUE.formed not in plain.compiled().slots
    assert CATALOGUE.formed in plain.with_effect("field_stiffness").compiled().slots
    assert CATALOGUE.formed not in static.with_effect("field_stiffness").compiled().slots
