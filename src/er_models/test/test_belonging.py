"""A damper belongs to its car, or is refused with the numbers that say why."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from er_models.belonging import check_belonging, ride
from er_models.catalogue import CATALOGUE
from er_models.constants import g
from er_models.errors import InputError
from er_models.files import load_model
from er_models.model import Model
from er_models.scales import Scales
from er_models.shipped import names, shipped

M, K_S, K_0, C = 300.0, 2.0e4, 1.0e3, 1.2e3
CAR = {"m_s": M, "m_us": 40.0, "k_s": K_S, "k_t": 2e5}


def linear(k: float = K_0, c: float = C, gas: float = 150.0) -> Model:
    """A car with a spring and a dashpot as damper."""
    effects = {"passive": {"k0": k, "c0": c}, "preload": {"F_0": gas}, "quarter_car": CAR}
    return Model("made", effects, Scales(1e3, 0.05, 0.6, 1.0))


def in_car(damper: str, car: str) -> Model:
    """A shipped car with another shipped damper."""
    vehicle, other = load_model(car), load_model(damper)
    kept = {"quarter_car": vehicle.effects["quarter_car"]}
    return replace(vehicle, effects={**other.effects, **kept}, scales=other.scales, rig=other.rig)


def test_of_a_linear_damper_the_numbers_are_those_of_the_textbook() -> None:
    found, k = ride(linear()), K_S + K_0
    assert found.static == pytest.approx(150.0 / k, rel=1e-9)
    assert found.weight == pytest.approx(M * g / k)
    assert found.frequency == pytest.approx(np.sqrt(k / M) / (2 * np.pi), rel=1e-4)
    assert found.damping == pytest.approx((C / (2 * np.sqrt(k * M)),) * 2, rel=1e-4)


@pytest.mark.parametrize("car", names("vehicles"))
def test_the_cars_that_are_shipped_have_dampers_of_their_size(car: str) -> None:
    check_belonging(load_model(shipped(car, "vehicles")))


@pytest.mark.parametrize("car", ["small_car", "large_car"])
def test_any_damper_of_a_car_may_be_put_into_one(car: str) -> None:
    for damper in ("car_er", "monotube_passive", "mr_hysteretic"):
        check_belonging(in_car(damper, car))


@pytest.mark.parametrize(
    ("model", "said"),
    [
        (linear(gas=5e3), "static deflection 238 mm (allowed up to 140 mm)"),
        (linear(k=2e6), "natural frequency 13.1 Hz (allowed 0.4 to 10 Hz)"),
        (linear(k=-1.99e4), "natural frequency 0.0919 Hz"),
        (linear(k=-3e4), "natural frequency 0 Hz"),
        (linear(c=100.0), "damping ratio 0.0199 (allowed 0.08 to 2)"),
        (linear(c=1e5), "damping ratio 19.9 (allowed 0.08 to 2)"),
        (in_car("monotube_passive", "inove_quarter_car"), "1500 N on a body of 2.27 kg: static"),
        (in_car("inove_guo", "small_car"), "one of 21 N on a body of 250 kg: damping ratio"),
        (in_car("car_er", "truck_corner"), "damping ratio 0.00675 to 0.0203 (allowed"),
    ],
)
def test_what_belongs_to_another_car_is_one_line_with_its_numbers(model: Model, said: str) -> None:
    with pytest.raises(InputError) as caught:
        check_belonging(model)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "effect", [e.name for e in CATALOGUE.effects if e.stage in ("force", "actuation", "heat")]
)
def test_whatever_may_hide_in_a_damper_is_no_reason_to_refuse_it(effect: str) -> None:
    car = load_model("inove_quarter_car")
    for which in range(2):
        values = {
            q.name: car.start(effect, q.name, which) for q in car.catalogue[effect].parameters
        }
        check_belonging(car.with_effect(effect, values))


def test_faults_and_sensors_are_no_reason_to_refuse_a_damper() -> None:
    model = load_model("inove_quarter_car")
    broken = model.with_effect("deflection_zero", {"x_0": 0.009})
    assert ride(broken) == ride(model)
