"""The observer on simulated drives: errors below one per cent, honest where it cannot know."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from er_models.model import Array, Model
from er_models.program import Program
from er_models.road.peak import factor_for_peak_velocity
from er_models.simulation import initial_state, prepare
from er_models.simulation import step as plant_step
from er_observers.gains import Gains, save_gains
from er_observers.observers.status import Status
from er_observers.running.evaluate import (
    DT,
    SCENARIOS,
    Scenario,
    evaluate,
    noisy,
    replay,
)
from er_observers.running.ready import ready
from er_observers.synthesis.make import Wish, synthesise

CHIRP, ISO = SCENARIOS[0], SCENARIOS[2]


@pytest.mark.parametrize("scenario", SCENARIOS, ids=lambda s: s.name)
def test_below_one_per_cent_from_10_mm_wrong(car: Model, gains: Gains, scenario: Scenario) -> None:
    """After 2 s, noise 0.025 m/s2, every drive: below 0.6 %, where 0.8 % was to be met."""
    score = evaluate(car, gains, scenario)
    assert score.nrmse < 0.006
    assert score.largest < 1.0
    assert score.first_ok is not None
    assert score.first_ok < (5.0 if scenario is CHIRP else 1.0)  # it begins slowly, before yield
    assert score.test_ratio < 1.0


def test_own_start_is_no_worse(car: Model, gains: Gains) -> None:
    """Without being told where the car is."""
    score = evaluate(car, gains, replace(ISO, deflection_error=None))
    assert score.nrmse < 0.006


def test_noise_and_duration_matter(car: Model, gains: Gains) -> None:
    """The figures measure something: ten times the noise is seen, and so is a late start."""
    plain = evaluate(car, gains, ISO)
    assert evaluate(car, gains, replace(ISO, noise=0.25)).rmse > 3.0 * plain.rmse
    assert evaluate(car, gains, replace(ISO, after=0.0)).rmse > 1.3 * plain.rmse


def test_skyhook_drive(car: Model, gains: Gains) -> None:
    """Closed loop (3.81) on the true velocities, full range of duty: below 0.8 %."""
    program = Program({"kind": "iso8608"}, {"kind": "constant", "level": 0.0}, 15.0, 5)
    t = np.arange(3001) * DT
    road, _ = program.signals(t)
    record = skyhook(car, road * factor_for_peak_velocity(car, road, DT, 0.15))
    scenario = Scenario("skyhook", program)
    estimates = replay(gains, noisy(record, scenario))
    error = np.array([e.force for e in estimates]) - record["damper_force"]
    rmse = float(np.sqrt(np.mean(error[400:] ** 2)))
    assert rmse / np.ptp(record["damper_force"][400:]) < 0.008
    assert np.mean([e.status is Status.OK for e in estimates[400:]]) > 0.98


def skyhook(car: Model, road: Array) -> dict[str, Array]:
    """Plant with the duty that (3.81) asks for, sample by sample."""
    plant = prepare(car, DT)
    state = initial_state(plant)
    rows = []
    for height in road[1:]:
        duty = 1.0 if state.q[1] * (state.q[1] - state.q[3]) >= 0.0 else 0.0
        state, out = plant_step(plant, state, (float(height), duty))
        rows.append(
            (state.t, out.sprung_acceleration, out.unsprung_acceleration, duty, out.damper_force)
        )
    table = np.array(rows).T
    names = ("t", "sprung_acceleration", "unsprung_acceleration", "duty", "damper_force")
    record = dict(zip(names, table, strict=True))
    record["duty"] = np.append(record["duty"][1:], record["duty"][-1])
    return record


def test_ten_per_cent_wrong_parameters(car: Model, gains: Gains) -> None:
    """Every parameter of the plant off by up to 10 %: still below 3 %, no false alarm."""
    random = np.random.default_rng(2)
    effects = {
        name: {q: v * random.uniform(0.9, 1.1) for q, v in values.items()}
        for name, values in car.effects.items()
    }
    score = evaluate(replace(car, effects=effects), gains, ISO)
    assert 0.005 < score.nrmse < 0.03
    assert score.test_ratio < 1.0


def test_hidden_friction(car: Model, gains: Gains) -> None:
    """A seal friction of 1 N that the gains know nothing of costs less than 2 %."""
    plant = car.with_effect("coulomb_friction", {"F_c": 1.0, "v_0": 0.003})
    score = evaluate(plant, gains, ISO)
    assert 0.005 < score.nrmse < 0.02


def test_slow_chirp_before_yield_is_called_weak(car: Model, gains: Gains) -> None:
    """Full field and a slow start: the start phase finds the 10 mm, and nobody could see them come back."""
    stiff = replace(CHIRP, program=replace(CHIRP.program, duty={"kind": "constant", "level": 1.0}))
    assert evaluate(car, replace(gains, opening=None), stiff).nrmse > 0.01
    score = evaluate(car, gains, stiff)
    assert score.nrmse < 0.006
    assert score.weak > 0.3
    assert score.first_ok is not None
    assert score.first_ok > 5.0


def test_a_deflection_sensor_ends_the_weakness(car: Model, tmp_path: Path) -> None:
    """The same theorem with a third output: never WEAK before yield, OK at once, through a gain file."""
    claim, certificate = synthesise("nlpv_polytopic", car, Wish(deflection=1e-3))
    save_gains(tmp_path / "gains.yaml", "nlpv_polytopic", car, claim, certificate)
    gains = ready(tmp_path / "gains.yaml", car, "nlpv_polytopic")
    assert gains.sees_deflection
    stiff = replace(CHIRP, program=replace(CHIRP.program, duty={"kind": "constant", "level": 1.0}))
    score = evaluate(car, gains, stiff)
    assert score.weak == 0.0
    assert score.nrmse < 0.0025
    assert score.first_ok is not None
    assert score.first_ok < 0.1
    assert certificate.slowest < -40.0
