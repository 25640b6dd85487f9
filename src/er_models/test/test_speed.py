"""Speed: bounds that only a lost order of magnitude can break, in processor time so that a busy machine does not."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from er_models.bench import DT, SECONDS, Line, damper, drive, prediction, scipy_force, table
from er_models.predict import predict
from er_models.simulate import simulate
from models_help import car, span


def used(run: Callable[[], object]) -> float:
    """Processor time of the fastest of five runs [s]."""
    run()
    best = np.inf
    for _ in range(5):
        start = time.process_time()
        run()
        best = min(best, time.process_time() - start)
    return float(best)


def test_a_minute_is_predicted_in_under_20_ms() -> None:
    inputs = drive()
    assert used(lambda: predict(damper(), inputs)) < 0.02


def test_a_minute_in_the_car_takes_under_a_quarter_of_a_second() -> None:
    t = np.arange(round(SECONDS / DT) + 1) * DT
    road = 0.004 * np.sin(2.0 * np.pi * 4.0 * t)
    assert used(lambda: simulate(car(), DT, road, drive().u)) < 0.25


def test_cost_is_linear_in_the_samples() -> None:
    short, long = drive(30.0), drive(120.0)
    ratio = used(lambda: predict(damper(), long)) / used(lambda: predict(damper(), short))
    assert 2.5 < ratio < 6.0


def test_the_reference_of_the_benchmark_is_the_same_model() -> None:
    """A ratio of times says nothing unless both compute the same."""
    part = drive(2.0)
    exact = scipy_force(damper(), part, 1e-9)
    assert np.abs(predict(damper(), part) - exact).max() < 1e-3 * span(exact)


def test_benchmark_compares_and_prints() -> None:
    lines = prediction()
    reference = next(line for line in lines if "SciPy" in line.what)
    assert reference.seconds > 20.0 * lines[0].seconds
    assert table([Line("what", 2.5e-3, "why")]).splitlines()[-1] == "| what | 2.5 ms | why |"
