"""The scheduled state feedback: its gains, what is proved of them, which acts, and what it does without sensors."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from er_ftc_controller.control import Ftc, Sample
from er_ftc_controller.gains import Loaded, load_gains
from er_ftc_controller.settings import FtcParameters, controller_of
from er_ftc_controller.state_law import COMFORT, START, Shares, StateLaw, step
from er_ftc_controller.synthesis.state_lqr import (
    StateDesign,
    StateWeights,
    car_of,
    state_gain,
    state_gains,
)
from er_ftc_controller.synthesis.state_proof import CORNERS, failed, loops_of, sampled
from er_models.errors import InputError
from er_models.files import load_model
from er_models.forms.loss import Factors
from er_models.gain_file import digest
from er_models.model import Model

from er_ftc_controller import control

CONFIG = Path(__file__).resolve().parents[3] / "config"
GAINS = CONFIG / "gains" / "lpv_ftc.yaml"
DT = 0.005


@pytest.fixture(scope="module")
def car() -> Model:
    return load_model(CONFIG / "vehicles" / "inove_quarter_car.yaml")


@pytest.fixture(scope="module")
def loaded(car: Model) -> Loaded:
    return load_gains(GAINS, car)


@pytest.fixture(scope="module")
def law(loaded: Loaded) -> StateLaw:
    assert loaded.feedback is not None
    return loaded.feedback.law


@pytest.fixture(scope="module")
def ftc(car: Model, loaded: Loaded) -> Ftc:
    given = yaml.safe_load((CONFIG / "nodes" / "ftc_controller.yaml").read_text())["/**"][
        "ros__parameters"
    ]
    return controller_of(FtcParameters(model_file="", gains_file="", **given), car, loaded)


def tone(law: StateLaw, hertz: float, seconds: float = 3.0) -> Shares:
    """Shares at the end of a swing of the body."""
    state, w = START, 2.0 * math.pi * hertz
    for k in range(round(seconds / DT)):
        swing, slope = 0.002 * math.sin(w * k * DT), 0.002 * w * math.cos(w * k * DT)
        state, _ = step(law, state, (swing, slope), (-(w**2) * swing, 0.0), 0.0, DT)
    return state.shares


def test_the_shipped_gains_are_those_of_the_design(car: Model, law: StateLaw) -> None:
    for shipped, made in zip(law.gains, state_gains(car, StateDesign()), strict=True):
        assert np.allclose(shipped, made, rtol=1e-6, atol=1e-6)


def test_a_gain_is_the_regulator_of_its_weights(car: Model) -> None:
    """Any other gain costs more: the cost of a start, by simulation of its own, is least at the one found."""
    weights = StateWeights(1.0, 1.0, 1.0, 4.0, 2.0)
    gain, (A, B, _) = state_gain(car, weights), car_of(car, Factors())
    from er_ftc_controller.synthesis.state_lqr import sizes_of

    sizes = np.array(
        [w * u for w, u in zip((1.0, 1.0, 1.0, 4.0, 2.0), sizes_of(car).units, strict=True)]
    )

    def cost(k: np.ndarray) -> float:
        x, total = np.array([0.01, 0.0, 0.0, 0.0, 0.0]), 0.0
        for _ in range(8000):
            goal = -float(k @ x)
            seen = np.array([float(A[1] @ x), x[0], x[1], x[2], goal]) / sizes
            total += 1e-4 * float(seen @ seen)
            x = x + 1e-4 * (A @ x + B * goal)
        return total

    least = cost(gain)
    assert all(cost(gain * share) > least for share in (0.7, 1.4))


def test_every_mixture_of_gains_is_stable_with_every_fault(car: Model, law: StateLaw) -> None:
    """Own eigenvalues at random mixtures and faults, between the corners that are proved."""
    loops = loops_of(car, [np.array(k) for k in law.gains], law.corner)
    rng = np.random.default_rng(3)
    steps = sampled(loops, DT)
    for _ in range(50):
        shares, corners = rng.dirichlet(np.ones(5)), rng.dirichlet(np.ones(len(CORNERS)))
        mixed = np.einsum("g,c,gcij->ij", shares, corners, loops.A)
        assert np.linalg.eigvals(mixed).real.max() < 0.0
        held = np.einsum("g,gij->ij", shares, steps[:, rng.integers(len(CORNERS))])
        assert np.abs(np.linalg.eigvals(held)).max() < 1.0


def test_what_is_not_proved_is_refused(car: Model, loaded: Loaded, tmp_path: Path) -> None:
    assert loaded.feedback is not None
    law, proof = loaded.feedback
    loops = loops_of(car, [np.array(k) for k in law.gains], law.corner)
    assert failed(loops, proof, DT) == ""
    assert "gamma" in failed(
        loops, replace(proof, gammas=tuple(0.5 * g for g in proof.gammas)), DT
    )
    assert "positive" in failed(loops, replace(proof, P=-proof.P), DT)
    assert "P_sampled" in failed(loops, replace(proof, P_sampled=np.eye(6)), DT)
    content = yaml.safe_load(GAINS.read_text())
    content["state_feedback"]["K"]["data"][6] *= -8.0
    content["digest"] = digest(content)
    path = tmp_path / "gains.yaml"
    path.write_text(yaml.safe_dump(content))
    with pytest.raises(InputError, match="state_feedback: expected inequalities that hold"):
        load_gains(path, car)


@pytest.mark.parametrize(
    ("hertz", "shares"),
    [(1.5, (1.0, 0.0, 0.0)), (4.3, (0.0, 1.0 - COMFORT[0], COMFORT[0])), (9.0, (0.0, 0.0, 0.0))],
)
def test_the_frequency_of_the_motion_chooses_the_gain(
    law: StateLaw, hertz: float, shares: tuple[float, float, float]
) -> None:
    """A part of the resonance's share goes to the gain that weighs comfort."""
    assert tone(law, hertz) == pytest.approx((*shares, 0.0), abs=0.02)


def test_a_leak_hands_a_rough_road_over_to_the_gain_of_the_leaking_car(law: StateLaw) -> None:
    """In proportion to what is lost of the viscous force, all of it at 0.6; a tone stays a tone."""

    def shares(left: float, *hertz: float) -> Shares:
        state = START
        for k in range(800):
            swings = [(0.004 / f, 2.0 * math.pi * f) for f in hertz]
            x = sum(a * math.sin(w * k * DT) for a, w in swings)
            v = sum(a * w * math.cos(w * k * DT) for a, w in swings)
            a_s = sum(-a * w**2 * math.sin(w * k * DT) for a, w in swings)
            state, _ = step(law, state, (x, v), (a_s, 0.0), 0.0, DT, left)
        return state.shares

    rough = (2.0, 4.3, 9.0, 16.0)
    healthy, half, lost = (shares(left, *rough) for left in (1.0, 0.8, 0.6))
    assert healthy.rough > 0.5
    assert healthy.leaking == lost.rough == 0.0
    assert half.leaking == pytest.approx(half.rough)
    assert half.leaking + half.rough == pytest.approx(healthy.rough)
    assert lost.leaking == pytest.approx(healthy.rough)
    assert shares(0.5, *rough) == lost
    for hertz in (1.5, 4.3, 7.0, 8.0, 10.0, 15.0):
        _, resonance, part, leaking = shares(0.6, hertz)
        assert (part, leaking) == pytest.approx((COMFORT[1] * (resonance + part), 0.0), abs=0.02)


def test_a_fast_edge_does_not_take_the_gain_from_what_follows(law: StateLaw) -> None:
    """For an eighth of a second a bump looks like a fast tone: it still finds the gain of the resonance."""
    assert tone(law, 9.0, 0.125).resonance > 0.9
    assert tone(law, 9.0, 1.0).resonance == 0.0


def test_without_accelerations_the_law_of_the_deflection_takes_over(ftc: Ftc) -> None:
    assert ftc.feedback is not None
    state, t = control.start(ftc), 0.0
    for k in range(200):
        t = k * DT
        x, v = 0.003 * math.sin(27.0 * t), 0.081 * math.cos(27.0 * t)
        state, _ = control.step(ftc, state, t, Sample(x, v, -729.0 * x, 0.0))
    assert state.feedback.shares.resonance > 0.9
    one, _ = control.step(ftc, state, t + DT, Sample(0.001, 0.08))
    assert one.feedback.missing == pytest.approx(DT)
    assert np.array_equal(one.control.x, ftc.rest.x)
    for k in range(1, 12):
        state, command = control.step(ftc, state, t + k * DT, Sample(0.001, 0.08))
    assert state.feedback == START
    assert not np.array_equal(state.control.x, ftc.rest.x)
    assert math.isfinite(command.duty)


def test_a_late_duty_is_meant_for_the_motion_that_it_meets(law: StateLaw) -> None:
    """On a tone, the goal of a late duty is near that of the sample that it will meet."""
    w, late = 2.0 * math.pi * 4.0, 0.01
    goals = {}
    for time in (0.0, late):
        state, goals[time] = START, []
        for k in range(800):
            s, c = math.sin(w * k * DT), math.cos(w * k * DT)
            motion, body = (0.003 * s, 0.003 * w * c), -0.002 * w * w * s
            accelerations = (body, body + 0.003 * w * w * s)
            state, goal = step(law, state, motion, accelerations, 0.0, DT, late=time)
            goals[time].append(goal)
    ahead = round(late / DT)
    exact, led, held = goals[0.0][400 + ahead :], goals[late][400:-ahead], goals[0.0][400:-ahead]
    error, without = (np.std(np.subtract(exact, each)) for each in (led, held))
    assert error < 0.5 * without  # the wheel is led on by its velocity, the tyre is not
