"""From force to duty: the force comes within the horizon in the damper's own equation, and every limit holds."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from er_ftc_controller.force_loop import (
    ForceLoop,
    LoopState,
    Motion,
    ahead,
    balance,
    duty_for,
    follow,
)
from er_models.errors import InputError
from er_models.files import load_model
from er_models.forms.loss import Factors, damaged
from er_models.rhs import damper_rate
from er_models.simulation import initial_state, prepare
from er_models.simulation import step as step_plant
from er_models.static_damper import static_damper
from scipy.integrate import solve_ivp

CONFIG = Path(__file__).resolve().parents[3] / "config"
CAR = load_model(CONFIG / "vehicles" / "inove_quarter_car.yaml")
TAU = CAR.value("response", "tau")
LEFT = Factors(0.8, 0.6, 0.9)
X, V = 0.002, 0.06


def loop(**changed: float) -> ForceLoop:
    """A loop of the testbench's damper, exact by default."""
    exact = {"correction": 0.0, "least_gate": 0.0, **changed}
    return ForceLoop(static_damper(CAR), TAU, (0.0, 1.0), **exact)  # type: ignore[arg-type]


def made(duty: float, begin: float, time: float) -> float:
    """Yield force after a time in the faulty damper's own differential equation."""
    car = damaged(CAR, LEFT)
    slot = car.catalogue.slots["response"]

    def rate(_: float, f: list[float]) -> list[float]:
        w = np.zeros(car.catalogue.n_states)
        w[slot] = f[0]
        return [float(damper_rate(car, w, X, V, 0.0, duty)[0][slot])]

    return float(solve_ivp(rate, (0.0, time), [begin], rtol=1e-10, atol=1e-12).y[0, -1])


@pytest.mark.parametrize("horizon", [0.005, 0.02])
@pytest.mark.parametrize(("begin", "wanted"), [(0.0, 0.9), (1.5, 1.4)])
def test_the_wanted_force_is_there_after_the_horizon(
    horizon: float, begin: float, wanted: float
) -> None:
    p = loop(horizon=horizon)
    gate = float(p.damper.gate(X, V))  # type: ignore[arg-type]
    _, duty = duty_for(p, LoopState(begin), wanted, gate, 0.005, LEFT)
    assert 0.0 < duty < 1.0
    assert made(duty, begin, horizon) == pytest.approx(wanted, abs=1e-6)


def test_a_latency_is_looked_over_with_the_duty_in_force() -> None:
    p, latency = loop(), 0.005
    gate = float(p.damper.gate(X, V))  # type: ignore[arg-type]
    _, duty = duty_for(p, LoopState(0.5, gate, 0.2), 2.0, gate, 0.005, LEFT, latency)
    assert made(duty, made(0.2, 0.5, latency), p.horizon) == pytest.approx(2.0, abs=1e-6)


def test_the_force_is_followed_as_the_car_has_it() -> None:
    """Along a ride with changing duty the state is F_er of the simulated damper, to what sampling leaves."""
    p, plant = loop(), prepare(CAR, 0.005)
    state, inner, errors, sizes = initial_state(plant), LoopState(), [], []
    for k in range(400):
        t, duty = 0.005 * k, 0.15 * (k // 40 % 3)
        road = 0.004 * math.sin(2.0 * math.pi * 4.0 * t)
        state, out = step_plant(plant, state, (road, duty))
        motion = Motion(out.deflection, out.deflection_velocity, duty=duty)
        inner = follow(p, inner, motion, 0.005, Factors())
        passive = float(p.damper.passive(out.deflection, out.deflection_velocity))  # type: ignore[arg-type]
        errors.append(inner.force - (out.damper_force - passive))
        sizes.append(out.damper_force - passive)
        told = balance(
            CAR.value("quarter_car", "m_s"), CAR.value("quarter_car", "k_s"),
            out.sprung_acceleration, out.deflection,
        )  # fmt: skip
        assert told == pytest.approx(out.damper_force, abs=1e-9)
    size = max(abs(v) for v in sizes)
    assert size > 1.0
    assert max(abs(e) for e in errors) < 0.12 * size


def test_an_estimated_force_draws_a_wrong_one_to_itself() -> None:
    p, inner = loop(correction=0.3), LoopState(force=5.0)
    passive = float(p.damper.passive(X, V, LEFT))  # type: ignore[arg-type]
    first = follow(p, inner, Motion(X, V, passive + 1.0, 0.0), 0.0, LEFT)
    assert first.force == pytest.approx(5.0 + 0.3 * (1.0 - 5.0))
    blind = follow(p, inner, Motion(X, V, math.nan, 0.0), 0.0, LEFT)
    assert blind.force == pytest.approx(5.0)


def test_limits_of_the_duty_hold_and_none_winds_up() -> None:
    gate = 1.0
    wanted = 1e3
    assert duty_for(loop(), LoopState(), wanted, gate, 0.005, LEFT)[1] == 1.0
    assert duty_for(loop(), LoopState(), -wanted, gate, 0.005, LEFT)[1] == 0.0
    assert duty_for(loop(slew=20.0), LoopState(duty=0.3), wanted, gate, 0.005, LEFT)[1] == 0.4
    assert duty_for(loop(dead_zone=0.1), LoopState(), 0.01, gate, 0.005, LEFT)[1] == 0.0
    shy = loop(dead_zone=0.1, horizon=math.inf)
    for leaves in (Factors(), Factors(electrical=0.5), Factors(leakage=0.5)):
        goal = float(shy.damper.height(0.15, leaves))
        duty = duty_for(shy, LoopState(), goal, gate, 0.005, leaves)[1]
        assert duty == pytest.approx(0.0 if leaves.electrical < 1.0 else 0.15)
    weak = duty_for(loop(least_gate=0.4), LoopState(), 0.3, 0.1, 0.005, LEFT)[1]
    assert weak == pytest.approx(duty_for(loop(), LoopState(), 0.3, 0.4, 0.005, LEFT)[1])
    assert duty_for(loop(), LoopState(duty=0.3), wanted, 0.0, 0.005, LEFT)[1] == 0.0
    assert duty_for(loop(), LoopState(duty=0.3), wanted, gate, 0.005, Factors(0.0))[1] == 0.0
    p, state = loop(), LoopState(gate=float(loop().damper.gate(X, V)))  # type: ignore[arg-type]
    for _ in range(400):  # far out of reach for two seconds
        state = follow(p, state, Motion(X, V), 0.005, LEFT)
        state, _ = duty_for(p, state, wanted, state.gate, 0.005, LEFT)
    top = state.force
    assert top <= float(p.damper.height(1.0, LEFT)) * state.gate * (1.0 + 1e-9)
    _, duty = duty_for(p, state, 0.5 * top, state.gate, 0.005, LEFT)
    assert duty == 0.0  # at once, not after the excess has been unwound


def test_the_motion_is_looked_ahead_by_the_accelerations() -> None:
    """A constant acceleration is exact, and one that is not known costs only its own part."""
    assert ahead(0.001, 0.2, 30.0, 0.01) == pytest.approx((0.001 + 0.002 + 0.0015, 0.5))
    assert ahead(0.001, 0.2, math.nan, 0.01) == pytest.approx((0.003, 0.2))


@pytest.mark.parametrize(
    "wrong", [{"horizon": 0.0}, {"correction": 1.1}, {"slew": 0.0}, {"least_gate": 1.0}]
)
def test_impossible_settings_are_named(wrong: dict[str, float]) -> None:
    with pytest.raises(InputError, match=next(iter(wrong))):
        loop(**wrong)
