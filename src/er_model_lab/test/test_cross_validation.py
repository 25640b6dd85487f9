"""What a model predicts without a block is what it predicts when it was fitted without that block."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from er_model_lab.diagnose.candidates import baseline, refit
from er_model_lab.fit import cross_validated, fit
from er_model_lab.prepare import FOLDS, prepare
from er_model_lab.record import Record
from er_models.files import load_model
from er_models.predict import motion, predict

GUO = Path(__file__).resolve().parents[3] / "config" / "dampers" / "inove_guo.yaml"
DT, FORCE_NOISE = 0.005, 0.15


def problem_of(effect, values, seconds=24.0, seed=1):
    """Measurements of an imposed motion of six sines with steps of duty, and the model without the effect."""
    model, rng = load_model(GUO), np.random.default_rng(seed)
    n = round(seconds / DT)
    w = 2 * np.pi * np.array([0.7, 1.3, 2.1, 3.4, 5.2, 7.3])
    size = 0.09 / w / 2.5
    phase = np.multiply.outer(np.arange(n) * DT, w) + rng.uniform(0, 2 * np.pi, w.size)
    x, v, a = np.sin(phase) @ size, np.cos(phase) @ (size * w), -np.sin(phase) @ (size * w**2)
    u = np.repeat(rng.choice([0.0, 0.1, 0.2, 0.3], n // 150 + 1), 150)[:n]
    force = predict(model.with_effect(effect, values), motion(DT, x, v, u, a))
    channels = {
        "deflection": x + 2e-5 * rng.standard_normal(n),
        "deflection_velocity": v + 1e-3 * rng.standard_normal(n),
        "sprung_acceleration": a + 0.025 * rng.standard_normal(n),
        "unsprung_acceleration": 0.025 * rng.standard_normal(n),
        "duty": u,
        "damper_force": force + FORCE_NOISE * rng.standard_normal(n),
    }
    return model, prepare([Record("made", np.arange(n) * DT, channels)])


def test_one_step_is_as_good_as_fitting_again():
    model, problem = problem_of("coulomb_friction", {"F_c": 1.0, "v_0": 0.003})
    full = fit(model.with_effect("coulomb_friction"), problem, max_iter=30)
    found, losses = cross_validated(full, problem)
    for b in (0, 5, FOLDS - 1):
        fold = np.where(problem.fold == b, -1, problem.fold)
        again = fit(full.model, replace(problem, fold=fold), max_iter=30)
        rows = problem.fold == b
        assert losses[b] == pytest.approx(np.mean(again.residual[rows] ** 2), rel=0.01)
        assert np.std(found[rows] - again.residual[rows]) < 0.1 * FORCE_NOISE


@pytest.mark.parametrize(
    ("effect", "values", "seed"),
    [("freeplay", {"b": 2.3e-5}, 6), ("cavitation", {"F_v": -10.0}, 1)],
)
def test_an_effect_that_jumps_is_not_lost_by_a_straight_line(effect, values, seed):
    model, problem = problem_of(effect, values, seed=seed)
    base = baseline(model, problem)
    found = refit(base, model.catalogue[effect], problem)
    assert found.fit.mse(problem.train) < 0.8 * base.fit.mse(problem.train)
    assert found.mse == pytest.approx(found.fit.mse(problem.train), rel=0.1)
