"""Domain, projection and scheduling parameter, against values worked by hand and the dynamic damper itself."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from er_ftc_controller.schedule import Schedule, project, reachable, scheduling
from er_models.errors import InputError
from er_models.files import load_model
from er_models.forms.loss import Factors, damaged
from er_models.rhs import damper_rate
from er_models.static_damper import Domain, static_damper
from scipy.integrate import solve_ivp

CONFIG = Path(__file__).resolve().parents[3] / "config"
P = Schedule(low=0.1, high=5.0, mu=0.5)


@pytest.mark.parametrize(
    ("distance", "rho"),
    [(0.0, 0.1), (0.5, 0.1), (0.75, 2.55), (1.0, 5.0), (9.0, 5.0), (math.nan, 5.0)],
)
def test_rho_is_that_of_6_16(distance: float, rho: float) -> None:
    assert scheduling(P, distance) == pytest.approx(rho)


def test_projection_is_the_nearest_force() -> None:
    domain = Domain(np.asarray(-2.0), np.asarray(3.0))
    assert project(1.0, domain) == (1.0, 0.0)
    assert project(5.0, domain) == (3.0, 2.0)
    assert project(-3.5, domain) == (-2.0, 1.5)


@pytest.mark.parametrize("values", [(0.0, 1.0, 1.0), (2.0, 1.0, 1.0), (0.1, 1.0, 0.0)])
def test_impossible_schedules_are_named(values: tuple[float, float, float]) -> None:
    with pytest.raises(InputError, match="schedule"):
        Schedule(*values)


@pytest.mark.parametrize("duty", [0.0, 1.0])
@pytest.mark.parametrize("motion", [(0.004, 0.05), (-0.002, -0.001)])
def test_reach_of_the_dynamic_damper_is_its_equation(
    duty: float, motion: tuple[float, float]
) -> None:
    """Each end is where the faulty damper's own differential equation goes at that duty."""
    left, start, horizon = Factors(0.8, 0.6, 0.9), 2.0, 0.02
    car = damaged(load_model(CONFIG / "vehicles" / "inove_quarter_car.yaml"), left)
    healthy = load_model(CONFIG / "dampers" / "inove_guo.yaml")
    slot, (x, v) = car.catalogue.slots["response"], motion

    def state(f: float) -> np.ndarray:
        w = np.zeros(car.catalogue.n_states)
        w[slot] = f
        return w

    run = solve_ivp(
        lambda _, f: [damper_rate(car, state(f[0]), x, v, 0.0, duty)[0][slot]],
        (0.0, horizon), [start], rtol=1e-10, atol=1e-12,
    )  # fmt: skip
    force = damper_rate(car, state(run.y[0, -1]), x, v, 0.0, duty)[1]
    damper, tau = static_damper(healthy), healthy.value("response", "tau")
    found = reachable(damper, tau, start, motion, (0.0, 1.0), horizon, left)
    assert min(abs(float(found.low) - force), abs(float(found.high) - force)) < 1e-6
    late = reachable(damper, tau, start, motion, (0.0, 1.0), 100.0 * tau, left)
    assert np.allclose(late, damper.domain(np.array(x), np.array(v), (0.0, 1.0), left))
