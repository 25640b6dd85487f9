"""What a model gets wrong is no noise: a rest, or the noise of the sensors, bounds what trees say."""

import numpy as np
import pytest
from er_model_lab.verbs.diagnose import diagnose
from er_models.files import load_model
from er_models.prediction import motion, predict
from er_records.dataset import Dataset
from er_records.record import Record
from lab_help import DT, FORCE_NOISE, GUO, imposed
from scipy.signal import lfilter

pytestmark = pytest.mark.slow

RAMP, REST = 200, 300


def record(hidden, *, rest=True, seconds=12.0):
    """A complete damper with a force that no tree predicts while it moves, and a rest of 1.5 s at the end."""
    model, rng, n = load_model(GUO), np.random.default_rng(5), round(seconds / DT)
    x, v, _, u = imposed(rng, n)
    share = np.ones(n)
    if rest:
        ramp = 0.5 + 0.5 * np.cos(np.pi * np.arange(RAMP) / RAMP)
        share[-RAMP - REST :] = np.append(ramp, np.zeros(REST))
        u[-REST - RAMP // 2 :] = 0.0
    slope = np.gradient(share, DT)
    x, v = x * share, v * share + x * slope
    a = np.gradient(v, DT)
    loud = lfilter([1.0], [1.0, -0.8], rng.standard_normal(n))
    force = predict(model, motion(DT, x, v, u, a)) + hidden * share * loud / loud.std()
    channels = {"deflection": x, "deflection_velocity": v, "duty": u, "damper_force": force,
                "sprung_acceleration": a, "unsprung_acceleration": np.zeros(n)}  # fmt: skip
    sizes = (2e-5, 1e-3, 0.0, FORCE_NOISE, 0.025, 0.025)
    noisy = {
        c: y + s * rng.standard_normal(n)
        for (c, y), s in zip(channels.items(), sizes, strict=True)
    }
    return Dataset.of([Record("made", np.arange(n) * DT, noisy)])


@pytest.fixture(scope="module")
def told():
    model = load_model(GUO)
    return {
        (hidden, rest): diagnose(record(hidden, rest=rest), model)
        for hidden, rest in ((0.5, True), (0.0, True), (0.5, False))
    }


def test_a_force_that_trees_do_not_predict_is_no_noise_where_a_rest_shows_the_noise(told):
    found = told[0.5, True]
    assert found.verdict == "unknown_effect"
    floors = found.to_dict()["floors"]
    assert floors["bound_train"]["value"] > 2.0 * floors["standstill_and_motion_sensors"]["value"]
    assert found.noise_floor < 1.3 * floors["standstill_and_motion_sensors"]["value"]
    assert "as a rest or repeats show it" in " ".join(found.to_dict()["reasons"])


def test_a_complete_model_stays_adequate(told):
    assert told[0.0, True].verdict == "adequate"


def test_without_a_rest_it_says_that_it_cannot_know(told):
    found = told[0.5, False]
    assert found.verdict == "insufficient_data"
    assert "record a rest" in " ".join(found.to_dict()["reasons"])
