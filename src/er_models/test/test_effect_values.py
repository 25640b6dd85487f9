"""Values of every effect, worked by hand in `effects/`: property tests cannot see a wrong factor."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import worked
from er_models.catalogue import CATALOGUE
from er_models.model import Model
from models_help import SMALL
from reference import vehicle_rate
from worked import CAR, PASSIVE, STATE

FILES = sorted(path.stem for path in worked.FOLDER.glob("*.py"))
CASES = [
    pytest.param(name, case, id=f"{name}-{k}")
    for name in FILES
    for k, case in enumerate(worked.of(name).WORKED)
]


def test_every_effect_has_its_file() -> None:
    assert sorted(CATALOGUE.names) == FILES
    assert {case.values[0] for case in CASES} == set(FILES)


@pytest.mark.parametrize(("name", "case"), CASES)
def test_the_kernel_computes_what_was_worked_by_hand(name: str, case: Any) -> None:
    case.check(name, CATALOGUE)


def test_quarter_car_moves_as_its_forces_say() -> None:
    model = Model("car", {**PASSIVE, **CAR}, SMALL)
    dq, _, outputs = vehicle_rate(
        model, np.array(STATE[:4]), np.zeros(CATALOGUE.n_states), 0.0, STATE[4]
    )
    assert outputs == pytest.approx([-8.0, 12.0, 6.0], rel=1e-9)
    assert dq == pytest.approx([0.1, -8.0, 0.15, 12.0], rel=1e-9)


def test_the_bias_of_an_accelerometer_moves_nothing() -> None:
    biased = {"accelerometer_bias": {"b_s": 0.5, "b_us": -0.25}}
    model = Model("car", {**PASSIVE, **CAR, **biased}, SMALL)
    _, _, outputs = vehicle_rate(
        model, np.array(STATE[:4]), np.zeros(CATALOGUE.n_states), 0.0, STATE[4]
    )
    assert outputs == pytest.approx([-8.0, 12.0, 6.0], rel=1e-9)
