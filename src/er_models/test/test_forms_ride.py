"""The pure functions that ride all forms over one road, and what sensors can tell of the car."""

from __future__ import annotations

import numpy as np
import pytest
from er_models.forms import ride
from er_models.forms.linearise import NotThisForm
from er_models.forms.loss import Factors, damaged
from er_models.forms.sensing import Sensing, sensings
from er_models.forms.zeros import visibility
from er_models.model import Array, Model
from er_models.road import road_profile
from er_models.simulation import simulate
from models_help import car as quarter_car

DT = 0.005


@pytest.fixture(scope="module")
def car() -> Model:
    """The quarter car of Table 2.1."""
    return quarter_car()


@pytest.fixture(scope="module")
def inputs() -> tuple[Array, Array]:
    """A road of ISO class C at the testbench's scale and a duty that jumps, half a second."""
    t = np.arange(101) * DT
    road = road_profile({"kind": "iso8608", "factor": 0.4, "speed": 15.0}, t, seed=2)
    return road, np.resize(np.repeat([0.0, 0.3, 1.0], 17), t.size)


def recorded(model: Model, road: Array, duty: Array) -> Array:
    """The signals of a ride as the integrator records them."""
    record = simulate(model, DT, road, duty)
    return np.column_stack([record[name] for name in ride.SIGNALS])


def largest(found: Array, wanted: Array) -> float:
    """Largest difference of any signal, as a share of its range."""
    return float((np.abs(found - wanted).max(axis=0) / np.ptp(wanted, axis=0)).max())


@pytest.mark.parametrize("form", [ride.lipschitz, ride.nlpv, ride.relative, ride.subsystems])
def test_every_form_rides_as_the_record(
    car: Model, inputs: tuple[Array, Array], form: ride.Ride
) -> None:
    """Deflection, accelerations and force of each form are those of the compiled model."""
    assert largest(form(car, DT, *inputs), recorded(car, *inputs)) < 3e-3


@pytest.mark.parametrize("left", [Factors(leakage=0.6), Factors(0.3, 0.9, 0.5)])
def test_faulty_car_rides_as_the_record(
    car: Model, inputs: tuple[Array, Array], left: Factors
) -> None:
    """(2.19) with a lost force is the compiled model with the fault in its parameters."""
    found, f = ride.descriptor(car, DT, *inputs, left)
    assert largest(found, recorded(damaged(car, left), *inputs)) < 3e-3
    assert largest(found, recorded(car, *inputs)) > 0.05
    assert np.ptp(f) > 5.0


def test_damage_needs_a_damper_of_three_terms(car: Model) -> None:
    """Friction and inertia are none of the terms of (6.8): the factors would not reach them."""
    for effect in ("coulomb_friction", "fluid_inertia"):
        with pytest.raises(NotThisForm, match=effect):
            damaged(car.with_effect(effect), Factors(leakage=0.5))


def chosen(car: Model) -> dict[tuple[str, int, int], Sensing]:
    """Systems by velocities, number of unknown inputs, number of outputs."""
    return {(s.velocities, s.D.shape[1], s.C.shape[0]): s for s in sensings(car)}


def test_zeros_of_every_choice_of_sensors(car: Model) -> None:
    """The climb hides from all sensors in absolute velocities; a lost force needs the deflection sensor."""
    decay = -1.0 / car.value("response", "tau")
    wanted = {
        ("absolute", 1, 2): [0.0],
        ("absolute", 1, 3): [0.0],
        ("absolute", 2, 2): [decay, 0.0, 0.0, 0.0],
        ("absolute", 2, 3): [decay, 0.0],
        ("relative", 1, 2): [],
        ("relative", 1, 3): [],
        ("relative", 2, 2): [decay, 0.0, 0.0],
        ("relative", 2, 3): [decay],
    }
    systems = chosen(car)
    assert set(systems) == set(wanted)
    for key, zeros in wanted.items():
        np.testing.assert_allclose(systems[key].zeros, zeros, atol=1e-3, err_msg=str(key))


def test_visibility_falls_towards_a_zero_and_only_there(car: Model) -> None:
    """A system with a zero at s = 0 loses a decade of visibility per decade of frequency, or two."""
    slow, systems = np.array([1e-3, 1e-2, 1e-1]), chosen(car)
    climb = visibility(*_matrices(systems["absolute", 1, 2]), slow)
    np.testing.assert_allclose(climb[1:] / climb[:-1], 10.0, rtol=0.05)
    clear = visibility(*_matrices(systems["relative", 1, 2]), slow)
    np.testing.assert_allclose(clear[1:] / clear[:-1], 1.0, rtol=0.05)
    fault = visibility(*_matrices(systems["relative", 2, 2]), slow)
    np.testing.assert_allclose(fault[1] / fault[0], 100.0, rtol=0.1)


def _matrices(system: Sensing) -> tuple[Array, Array, Array, Array]:
    return system.A, system.D, system.C, system.H
