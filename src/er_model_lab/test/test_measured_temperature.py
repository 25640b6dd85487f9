"""A measured temperature: what follows it is tried where one was measured, and found beside rivals of time."""

import numpy as np
import pytest
from er_model_lab.diagnosis.candidates import baseline, effect_size, missing, refit
from er_model_lab.problem.prepare import prepare
from er_models.files import load_model
from er_models.prediction import motion, predict
from er_records.dataset import Dataset
from er_records.record import Record
from lab_help import DT, FORCE_NOISE, GUO, imposed

ARRHENIUS, COLD = 2000.0, 293.0
"""Activation temperature of the viscosity, and temperature at the beginning [K]."""
NAME = "temperature_thinning"


def warmed(measures):
    """A minute of a damper that warms, cools and warms by 25 K, with the viscosity of Andrade's law; its problem."""
    model, rng = load_model(GUO), np.random.default_rng(5)
    n = round(60.0 / DT)
    t = np.arange(n) * DT
    x, v, a, u = imposed(rng, n)
    theta = 12.5 * (1.0 - np.cos(2.0 * np.pi * t / 40.0))
    thinner = np.exp(ARRHENIUS * (1.0 / (COLD + theta) - 1.0 / COLD))
    force = predict(model, motion(DT, x, v, u, a))
    force = force - (1.0 - thinner) * model.value("passive", "c0") * v
    channels = {
        "deflection": x + 2e-5 * rng.standard_normal(n),
        "deflection_velocity": v + 1e-3 * rng.standard_normal(n),
        "duty": u,
        "damper_force": force + FORCE_NOISE * rng.standard_normal(n),
        "sprung_acceleration": a + 0.025 * rng.standard_normal(n),
        "unsprung_acceleration": 0.025 * rng.standard_normal(n),
    }
    if measures:
        channels["temperature"] = COLD + theta + 0.2 * rng.standard_normal(n)
    return model, prepare(Dataset.of([Record("made", t, channels)]))


def test_a_viscosity_that_follows_the_temperature_is_found():
    """Its loss is that of Andrade's law, 2000 K / (293 K)^2 = 2.3 % per kelvin at first, a little less over 25 K."""
    model, problem = warmed(measures=True)
    base = baseline(model, problem)
    assert NAME in {e.name for e in missing(base.fit.model, problem)}
    found = refit(base, model.catalogue[NAME], problem)
    values = found.fit.model.effects[NAME]
    assert values["b_v"] == pytest.approx(ARRHENIUS / COLD**2, rel=0.1)
    assert abs(values["b_y"]) < 1e-3
    size = effect_size(base, found)
    others = ("self_heating", "effectiveness_fade", "force_fade")
    rivals = [refit(base, model.catalogue[name], problem) for name in others]
    assert max(effect_size(base, other) for other in rivals) < 0.6 * size


def test_nothing_follows_a_temperature_that_nobody_measured():
    model, problem = warmed(measures=False)
    assert NAME not in {e.name for e in missing(model, problem)}
