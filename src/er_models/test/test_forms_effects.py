"""Effects on top of the quarter car: a form that is given out moves as the model, any other is refused."""

from __future__ import annotations

import numpy as np
import pytest
from er_models.catalogue import CATALOGUE
from er_models.forms.linearise import NotThisForm
from er_models.forms.lipschitz import LinearForm, linearise
from er_models.model import Array, Model
from er_models.road import road_profile
from er_models.simulation import simulate
from models_help import car as quarter_car
from scipy.integrate import solve_ivp

REFUSED = {
    "dead_time", "self_heating", "effectiveness_fade", "force_fade", "viscoelastic_branch", "bouc_wen_hysteresis",
    "mount_compliance", "tyre_damping", "tyre_lift_off", "guide_friction", "spring_nonlinearity",
    "accelerometer_bias",
}  # fmt: skip
"""Effects that a form could overlook: a delay, a state of their own, time, the road's rate, a reading."""


@pytest.fixture(scope="module")
def car() -> Model:
    """The quarter car of Table 2.1."""
    return quarter_car()


def assert_close(found: Array, wanted: Array, share: float) -> None:
    """Every column agrees to a share of its range."""
    difference = np.abs(found - wanted).max(axis=0) / np.ptp(wanted, axis=0)
    assert difference.max() < share, difference


def sampled(n: int) -> tuple[float, Array, Array]:
    """Sample time, a road and a duty that jumps, (n,) each."""
    dt = 0.005
    road = road_profile(
        {"kind": "iso8608", "factor": 0.4, "speed": 15.0}, np.arange(n) * dt, seed=1
    )
    return dt, road, np.resize(np.repeat([0.0, 0.3, 1.0, 0.1, 0.6], 11), n)


def recorded(form: LinearForm, dt: float, road: Array, duty: Array) -> Array:
    """States (n, 5) of the Lipschitz form on a sampled road, the duty held from each sample on."""
    x, out = np.zeros(5), []
    for k in range(road.size):
        out.append(x)
        slope = (road[min(k + 1, road.size - 1)] - road[k]) / dt

        def rate(s: float, y: Array, u: float = duty[k], w: float = slope) -> Array:
            return form.rate(y, u, w)

        x = solve_ivp(rate, (0.0, dt), x, method="LSODA", rtol=1e-8, atol=1e-11).y[:, -1]
    return np.array(out)


def test_recorded_simulation_comes_to_the_exact_form(car: Model) -> None:
    """The integrator that makes records agrees with the form, and the more the shorter its steps are."""
    n, split = 161, 40
    dt, road, duty = sampled(n)
    form, fine = linearise(car), np.arange(split * (n - 1) + 1) / split
    wanted = recorded(form, dt, road, duty) @ np.vstack([form.F, np.eye(5)[0]]).T
    exact = simulate(car, dt / split, np.interp(fine, np.arange(n), road), duty[fine.astype(int)])
    coarse = simulate(car, dt, road, duty)
    for record, step, share in ((coarse, 1, 5e-3), (exact, split, 2e-4)):
        found = np.column_stack([record["damper_force"], record["deflection"]])
        assert_close(found[::step], wanted, share)


NAMES = [e.name for e in CATALOGUE.effects if e.stage != "core" and e.name != "quarter_car"]


@pytest.mark.parametrize("name", NAMES)
def test_a_form_that_is_given_out_moves_as_the_model(car: Model, name: str) -> None:
    """With any effect added, the accelerometers read what the form says, or there is no form."""
    model, form, refusal = car.with_effect(name), None, ""
    try:
        form = linearise(model)
    except NotThisForm as error:
        refusal = str(error)
    if form is None:
        assert f"leave out one of {name}" in refusal or f"leave out {name}" in refusal
        return
    assert name not in REFUSED
    dt, road, duty = sampled(101)
    record = simulate(model, dt, road, duty)
    found = recorded(form, dt, road, duty) @ form.C.T
    wanted = np.column_stack([record["sprung_acceleration"], record["unsprung_acceleration"]])
    assert_close(found, wanted, 5e-3)
