"""Sensors: what the plant reports is what the damper model takes back."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from er_models.catalogue import CATALOGUE
from er_models.effect import Effect, Param, Signature
from er_models.errors import InputError
from er_models.model import Model
from er_models.prediction import motion, predict
from er_models.reading import delay, reading
from er_models.simulation import prepare, simulate
from models_help import DT, car, span

ROAD = 0.003 * np.sin(2.0 * np.pi * 3.0 * np.arange(400) * DT)
DUTY = np.repeat([0.1, 0.25, 0.05, 0.3], 100)


def plant(name: str, **values: float) -> Model:
    return car().with_effect(name, values)


def test_deflection_zero_shifts_the_channel_and_nothing_else() -> None:
    true, run = (simulate(m, DT, ROAD, DUTY) for m in (car(), plant("deflection_zero", x_0=0.002)))
    assert run["deflection"] == pytest.approx(true["deflection"] - 0.002, abs=1e-15)
    for channel in ("damper_force", "deflection_velocity", "sprung_acceleration"):
        assert np.array_equal(run[channel], true[channel])


def test_velocity_lag_is_a_first_order_filter() -> None:
    """T_v v_m' + v_m = v: the true velocity is found again from the channel and its derivative."""
    dt, lag = 1e-3, 0.01
    road = 0.003 * np.sin(2.0 * np.pi * 3.0 * np.arange(1000) * dt)
    duty = np.zeros(1000)
    true, run = (simulate(m, dt, road, duty) for m in (car(), plant("velocity_lag", T_v=lag)))
    measured = run["deflection_velocity"]
    again = measured + lag * np.gradient(measured, dt, edge_order=2)
    error = (again - true["deflection_velocity"])[20:-5]
    assert np.abs(error).max() < 2e-3 * span(measured)
    assert np.abs(measured - true["deflection_velocity"]).max() > 0.05 * span(measured)
    assert np.array_equal(run["damper_force"], true["damper_force"])


@pytest.mark.parametrize("late", [0.002, 0.005, 0.0137, 0.02])
def test_force_delay_reports_the_force_of_before(late: float) -> None:
    """Against the force at the instant itself, from a run with a finer sample."""
    fine = 5e-4
    t = np.arange(4000) * fine
    road, duty = np.interp(t, np.arange(400) * DT, ROAD), np.repeat(DUTY, 10)
    force = simulate(car(), fine, road, duty)["damper_force"]
    run = simulate(plant("force_delay", d=late), DT, ROAD, DUTY)["damper_force"]
    instants = np.arange(400) * DT - late
    exact = np.interp(instants, t, force)
    later = instants >= 0.0
    assert np.abs(run - exact)[later].max() < 2e-3 * span(force)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("deflection_zero", {"x_0": 0.002}),
        ("force_lag", {"T_f": 0.004}),
        ("force_delay", {"d": 0.004}),
        ("velocity_lag", {"T_v": 0.004}),
    ],
)
def test_prediction_takes_back_what_the_plant_reports(name: str, values: dict[str, float]) -> None:
    """The effect explains its own record, the model without it does not."""
    model = plant(name, **values)
    run = simulate(model, DT, ROAD, DUTY)
    acceleration = run["sprung_acceleration"] - run["unsprung_acceleration"]
    if name == "velocity_lag":
        acceleration = np.gradient(run["deflection_velocity"], DT)
    record = motion(DT, run["deflection"], run["deflection_velocity"], run["duty"], acceleration)
    with_it = (predict(model, record) - run["damper_force"])[20:]
    without = (predict(car(), record) - run["damper_force"])[20:]
    assert with_it.std() < 0.25 * without.std()


@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        ("force_delay", {"d": -0.002}, "force_delay: expected a delay of 0 s or more to simulate"),
        (
            "velocity_lag",
            {"T_v": -0.002},
            "velocity_lag: expected a lag of 0 s or more to simulate",
        ),
    ],
)
def test_a_sensor_cannot_be_early(name: str, values: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        prepare(plant(name, **values), DT)


def _sensor(name: str, **hooks: object) -> Effect:
    """A user's sensor with one parameter g."""
    return Effect(
        name, "sensing", name, name, (Param("g", "1", 0.1, 10.0, 1.0, (2.0,), "gain"),),
        hooks,  # type: ignore[arg-type]
        Signature("none", "none", "none"), "a test",
    )  # fmt: skip


def gained(g: float, x: float) -> float:
    """True deflection."""
    return g * x


def bent(g: float, x: float) -> float:
    """True deflection of a sensor that is no straight line."""
    return x + g * x * x


def test_a_users_own_sensors_add_up_in_their_order() -> None:
    more = CATALOGUE.extended([_sensor("gain", shift_deflection=gained)])
    model = dataclasses.replace(plant("deflection_zero", x_0=0.01), catalogue=more)
    model = model.with_effect("gain", {"g": 2.0})
    assert reading(model) == pytest.approx([2.0, 0.02, 1.0, 0.0, 0.0])
    assert delay(model) == 0.0


def test_a_bent_sensor_is_refused() -> None:
    more = CATALOGUE.extended([_sensor("bent", shift_deflection=bent)])
    model = dataclasses.replace(car(), catalogue=more).with_effect("bent")
    with pytest.raises(InputError, match="a sensor with a straight line"):
        reading(model)
