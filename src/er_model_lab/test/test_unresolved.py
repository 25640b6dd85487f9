"""Motion whose accelerations 200 Hz do not resolve: a simulated car on a road of straight lines."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from er_model_lab.diagnosis.investigation import search_effects
from er_model_lab.fitting.velocity_channel import on_fused
from er_model_lab.level.damper import opened
from er_models.files import load_model
from er_models.program import load_program, resolve, times
from er_models.simulation import simulate
from er_records.dataset import Dataset
from er_records.record import Record

CONFIG = Path(__file__).resolve().parents[3] / "config"
DT = 0.005
NOISE = {
    "damper_force": 0.15, "sprung_acceleration": 0.025, "unsprung_acceleration": 0.025, "deflection": 2e-5,
    "deflection_velocity": 1e-3,
}  # fmt: skip


@pytest.fixture(scope="module")
def rough():
    """What an ideal sensor reads of the velocity, and the problem of a complete model."""
    car, rng = load_model(CONFIG / "vehicles/inove_quarter_car.yaml"), np.random.default_rng(2)
    program = replace(load_program(CONFIG / "experiments/iso_steps.yaml"), duration=15.0)
    t = times(program.duration, DT)
    road, duty = resolve(program, car, DT).signals(t)
    run = simulate(car, DT, road, duty)
    noisy = {name: run[name] + sd * rng.standard_normal(t.size) for name, sd in NOISE.items()}
    record = Record("rough", t, noisy | {"duty": duty})
    model = load_model(CONFIG / "dampers/inove_guo.yaml")
    return run["deflection_velocity"], model, opened(Dataset.of([record]), model).problem


def test_the_velocity_is_as_uncertain_as_it_is_said_to_be(rough):
    truth, _, problem = rough
    fused = problem.fused[0]
    assert any("faster than the sampling resolves" in note for note in problem.notes)
    assert problem.noise.v == pytest.approx(NOISE["deflection_velocity"], rel=0.25)
    said = np.sqrt(np.mean(fused.sd_v**2))
    assert np.std(fused.v - truth) == pytest.approx(said, rel=0.3)


def test_a_complete_model_is_adequate_there_too(rough):
    _, model, problem = rough
    found = search_effects(on_fused(model), problem)
    assert (found.verdict, found.effects, found.floor.bursts) == ("adequate", (), 0.0)
