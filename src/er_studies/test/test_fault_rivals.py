"""The descriptor H-infinity observer of the lost force: proved, not with less, and right where it can be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from er_models.model import Model
from er_observers.faults.rules import estimator
from er_studies.faults.rivals import factors
from er_studies.faults.synthesis.lost_force import Design, LostForce, design, proved, solve
from er_studies.faults.trials import Trial, drive


@pytest.fixture(scope="module")
def solved(car: Model) -> tuple[Design, LostForce]:
    """The shipped car at the duties of its rig."""
    problem = design(car, estimator(car).noise[:3], car.rig["duty_max"])
    return problem, solve(problem)


def test_the_gain_is_proved_and_no_smaller_one_is(solved: tuple[Design, LostForce]) -> None:
    problem, found = solved
    assert proved(problem, found)
    assert not proved(problem, replace(found, gamma=0.9 * found.gamma))
    for wrong in (-1.0, 0.5, 2.0):
        assert not proved(problem, replace(found, K=wrong * found.K))
    assert not proved(replace(problem, gate=10.0 * problem.gate), found)


def test_gamma_bounds_the_gain_of_the_error_that_is_simulated(
    car: Model, solved: tuple[Design, LostForce]
) -> None:
    """At every constant slope of the gate, over frequency, with the gain in SI units."""
    problem, found = solved
    down, rate = problem.units, 100.0
    A0, B = problem.A * rate * down[:, None] / down, problem.B[:, 0] * rate * down
    W, h = problem.W * rate * down[:, None], problem.h[0] / down
    N = np.diag(problem.noise[2:]) @ problem.N
    worst = 0.0
    for slope in (0.0, 0.5, 1.0):
        A = A0 - found.K @ np.eye(2, 3) + slope * np.outer(B, problem.gate[0] / down)
        assert np.linalg.eigvals(A).real.max() < 0.0
        for w in np.geomspace(0.1, 1e4, 60):
            gain = h @ np.linalg.solve(1j * w * np.eye(3) - A, W - found.K @ N) + problem.D[0]
            worst = max(worst, float(np.linalg.norm(gain)))
    assert 0.05 * found.gamma < worst < found.gamma


def test_it_finds_a_lost_yield_force(car: Model, solved: tuple[Design, LostForce]) -> None:
    record = drive(Trial(1004, {"f1": 0.5}, fault_time=4.0, duration=9.0, road="steps"), car)
    found = factors(estimator(car), record.samples, "descriptor", solved[1].K)
    assert found[750, 0] == pytest.approx(1.0, abs=0.15)
    assert found[-1, 0] == pytest.approx(0.5, abs=0.15)
