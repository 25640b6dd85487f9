"""What the tests of the observers share: the thesis's car, its committed gains, one synthesis."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
from er_models.files import load_model
from er_models.model import Model
from er_models.simulation import simulate
from er_observers.gains import Gains
from er_observers.running.ready import ready
from er_observers.running.runtime import Sample
from er_observers.synthesis.certify import Certificate
from er_observers.synthesis.make import Wish, synthesise
from er_observers.synthesis.proof import Claim

DT = 0.005
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


@pytest.fixture(scope="session")
def synthesis(car: Model) -> tuple[Claim, Certificate]:
    """A fresh synthesis with the default specification."""
    return synthesise("nlpv_polytopic", car, Wish())


@pytest.fixture(scope="session")
def drive(car: Model) -> Callable[..., list[Sample]]:
    """Samples of a simulated rough road with sensor noise: ``drive(n, duty)``."""

    @lru_cache
    def samples(n: int = 400, duty: float = 0.2) -> list[Sample]:
        random, k = np.random.default_rng(3), np.arange(n)
        waves = ((3.1, 2e-3), (5.7, 1e-3), (9.3, 5e-4), (15.0, 3e-4))
        road = np.sum([a * np.sin(2 * np.pi * f * DT * k + f) for f, a in waves], axis=0)
        record = simulate(car, DT, road, np.full(n, duty))
        names = ("sprung_acceleration", "unsprung_acceleration")
        y = np.array([record[name] for name in names]) + 0.025 * random.normal(size=(2, n))
        return [Sample(DT * i, float(y[0, i]), float(y[1, i]), duty) for i in range(n)]

    return samples
