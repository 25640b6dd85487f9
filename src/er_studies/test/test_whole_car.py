"""Controllers of the whole car: rides, rows and the table."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from er_models.car.files import load_car
from er_studies.control import whole_car

CONFIG = Path(__file__).resolve().parents[3] / "config"


def test_duty_costs_comfort_and_saves_deflection() -> None:
    car = load_car(CONFIG / "cars/inove_car.yaml")
    road = whole_car.rough(car, 3.0, 5)
    free, held = (whole_car.drive(car, *road, whole_car.constant(u)) for u in (0.0, 0.2))
    again = whole_car.drive(car, *whole_car.rough(car, 3.0, 5), whole_car.constant(0.0))
    assert np.array_equal(free, again)
    assert held[0] > free[0]
    assert held[4] < free[4]


def test_the_regulator_leans_less_in_turns() -> None:
    car = load_car(CONFIG / "cars/inove_car.yaml")
    ride = whole_car.handling(car)
    free = whole_car.drive(car, *ride, whole_car.constant(0.0))
    gains = CONFIG / "gains/body_lqr.yaml"
    held = whole_car.drive(car, *ride, whole_car.regulator(car, gains))
    assert held[2] < 0.96 * free[2]
    assert held[3] < 0.93 * free[3]


def test_the_table_names_rides_and_controllers() -> None:
    found = [
        ("rough road", name, np.arange(1.0, 7.0) * k)
        for name, k in (("no field", 1.0), ("x", 1.1))
    ]
    text = whole_car.markdown(found)
    assert text.splitlines()[0] == "### Rough road"
    assert "| no field | 1 | 2 | 3 | 4 | 5 | 6 |" in text
    assert "| x | +10 % |" in text
