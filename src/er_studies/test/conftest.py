"""What the tests of the studies share: the thesis's car and its committed gains."""

from __future__ import annotations

from pathlib import Path

import pytest
from er_models.files import load_model
from er_models.model import Model
from er_observers.gains import Gains
from er_observers.running.ready import ready

CONFIG = Path(__file__).resolve().parents[3] / "config"


@pytest.fixture(scope="session")
def car_file() -> Path:
    """Model file of the quarter car of Table 2.1."""
    return CONFIG / "vehicles" / "inove_quarter_car.yaml"


@pytest.fixture(scope="session")
def gain_file() -> Path:
    """The committed gains."""
    return CONFIG / "gains" / "nlpv_polytopic.yaml"


@pytest.fixture(scope="session")
def car(car_file: Path) -> Model:
    """The quarter car of Table 2.1."""
    return load_model(car_file)


@pytest.fixture(scope="session")
def gains(car: Model, gain_file: Path) -> Gains:
    """The committed gains, loaded."""
    return ready(gain_file, car, "nlpv_polytopic")
