"""A motion that repeats itself is known as such, and nothing is named with certainty on it."""

from dataclasses import replace

import numpy as np
import pytest
from er_model_lab.diagnosis.candidates import baseline, refit
from er_model_lab.diagnosis.investigation import search_effects
from er_model_lab.diagnosis.null import simulate_null
from er_model_lab.level.damper import opened
from er_model_lab.motion.repetition import cycle
from er_model_lab.planning.suggest import suggestions
from er_model_lab.preflight.check import preflight
from er_models.files import load_model
from er_models.prediction import motion, predict
from er_records.dataset import Dataset
from er_records.record import Record
from lab_help import DT, GUO, imposed

N = 2400
T = np.arange(N) * DT


def curve(f, rng, noise=1e-3):
    """Velocity of a cycle with harmonics, as a nonlinear damper gives to a wheel on a sine."""
    v = (
        np.sin(2 * np.pi * f * T)
        + 0.3 * np.sin(6 * np.pi * f * T)
        + 0.2 * np.cos(4 * np.pi * f * T)
    )
    return 0.1 * v + noise * rng.standard_normal(N)


@pytest.mark.parametrize("f", [0.73, 1.9, 3.377])
def test_a_cycle_is_found_with_its_frequency(f):
    found = cycle(curve(f, np.random.default_rng(1)), DT)
    assert found.frequency == pytest.approx(f, rel=2e-3)
    assert found.share > 0.99


def test_the_strongest_line_need_not_be_the_fundamental():
    v = np.sin(2 * np.pi * 3.0 * T) + 0.5 * np.sin(2 * np.pi * 1.5 * T)
    assert cycle(v, DT).frequency == pytest.approx(1.5, rel=1e-3)


@pytest.mark.parametrize(("seconds", "repeats"), [(2.0, True), (12.0, False)])
def test_a_machine_may_run_up_before_its_motion_repeats_itself(seconds, repeats):
    """The free vibration of the start dies away within a few cycles of a minute; a fifth of it is another test."""
    t = np.arange(round(60.0 / DT)) * DT
    v = 0.02 * np.sin(2 * np.pi * 4.0 * t)
    v[t < seconds] += 0.03 * np.sin(2 * np.pi * 5.3 * t[t < seconds])
    v += 1e-3 * np.random.default_rng(3).standard_normal(t.size)
    assert (cycle(v, DT) is not None) is repeats


@pytest.mark.parametrize("kind", ["rough", "sweep", "two", "short"])
def test_other_motion_repeats_nothing(kind):
    rng = np.random.default_rng(2)
    v = {
        "rough": imposed(rng, N)[1],
        "sweep": np.sin(2 * np.pi * (1.0 + 0.02 * T) * T),
        "two": np.sin(2 * np.pi * 1.3 * T) + 0.3 * np.sin(2 * np.pi * 3.1 * T + 1.0),
        "short": np.sin(2 * np.pi * 0.15 * T),
    }[kind]
    assert cycle(v, DT) is None


def sine_record(hidden=None, blur=1.0):
    """One sine of 2 Hz at one duty, with an effect that the model may lack."""
    rng, w, model = np.random.default_rng(4), 2 * np.pi * 2.0, load_model(GUO)
    x, v, a = 4e-3 * np.sin(w * T), 4e-3 * w * np.cos(w * T), -4e-3 * w**2 * np.sin(w * T)
    u, noise = np.full(N, 0.1), rng.standard_normal((5, N))
    truth = model.with_effect(*hidden) if hidden else model
    channels = {
        "deflection": x + blur * 2e-5 * noise[0], "deflection_velocity": v + blur * 1e-3 * noise[1], "duty": u,
        "sprung_acceleration": a + blur * 0.025 * noise[2], "unsprung_acceleration": blur * 0.025 * noise[3],
        "damper_force": predict(truth, motion(DT, x, v, u, a)) + 0.15 * noise[4],
    }  # fmt: skip
    return model, Record("sine", T, channels)


def test_on_one_sine_nothing_is_certain():
    model, record = sine_record(("coulomb_friction", {"F_c": 0.8, "v_0": 0.01}))
    problem = opened(Dataset.of([record]), model).problem
    found = search_effects(model, problem)
    assert found.coverage.curves == 1
    assert found.effects
    assert found.verdict == "ambiguous"
    assert any("closed curve at 2 Hz" in r for r in found.reasons)
    (said,) = (f for f in preflight([record]).findings if f.check == "motion")
    assert (said.level, "told apart" in said.found) == ("warning", True)


def test_what_fusion_misses_in_every_cycle_is_no_effect():
    model, record = sine_record(blur=5.0)
    problem = opened(Dataset.of([record]), model).problem
    base, averaging = baseline(model, problem), replace(problem)
    vars(averaging)["cycles"] = ()
    rivals = [refit(base, model.catalogue["mount_compliance"], problem)]
    null, averaged = (simulate_null(base, rivals, p, 0) for p in (problem, averaging))
    assert averaged.threshold(0.05) < null.input_error == null.threshold(0.05)
    assert null.p_value(0.9 * null.input_error) == 1.0 > averaged.p_value(0.9 * null.input_error)


def test_a_name_that_is_unsure_asks_for_the_experiment():
    candidates = [
        {"effect": e, "evidence": size, "threshold": 0.02, "rmse_cross_validated": rmse, "status": "not_needed"}
        for e, size, rmse in (("coulomb_friction", 0.3, 0.16), ("freeplay", 0.1, 0.2), ("shear_thinning", 0.2, 0.18))
    ]  # fmt: skip
    result = {
        "verdict": "ambiguous",
        "effects": ["coulomb_friction"],
        "alternatives": [],
        "candidates": candidates,
    }
    assert suggestions(result) == [{"between": ["coulomb_friction", "shear_thinning"]}]
