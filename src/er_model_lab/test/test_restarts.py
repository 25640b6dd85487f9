"""Terms begun anew: a play that one effect hands over to another, in front of the whole damper."""

import numpy as np
import pytest
from er_model_lab.diagnosis.candidates import baseline, finished, refit
from er_model_lab.diagnosis.restarts import handed_over
from er_model_lab.problem.prepare import prepare
from er_models.files import load_model
from er_models.prediction import motion, predict
from er_records.dataset import Dataset
from er_records.record import Record
from lab_help import DT, GUO, imposed

SHUT = {"F_h": 60.0, "z_y": 4e-4, "b": 0.0}


def brake(seed):
    """A brake behind a gap, its pads bending: the model without either, and measurements of it."""
    rng = np.random.default_rng(seed)
    x, v, a, u = imposed(rng, 2400)
    bare = load_model(GUO).without_effect("guo_yield").without_effect("response")
    model = bare.with_effect("passive", {"k0": 2000.0, "c0": 200.0}).with_effect(
        "coulomb_friction", {"F_c": 60.0, "v_0": 0.003}
    )
    truth = model.with_effect("friction_with_play", SHUT).with_effect("freeplay", {"b": 2e-3})
    channels = {
        "deflection": x + 2e-6 * rng.standard_normal(x.size),
        "deflection_velocity": v + 1e-4 * rng.standard_normal(x.size),
        "sprung_acceleration": a + 0.01 * rng.standard_normal(x.size),
        "unsprung_acceleration": 0.01 * rng.standard_normal(x.size),
        "duty": 0.0 * u,
        "damper_force": predict(truth, motion(DT, x, v, 0.0 * u, a)) + rng.standard_normal(x.size),
    }
    return model, prepare(Dataset.of([Record("brake", np.arange(x.size) * DT, channels)]))


def test_a_play_of_its_own_is_handed_over():
    model, problem = brake(3)
    own = model.with_effect("friction_with_play", {**SHUT, "b": 1.5e-3})
    found = handed_over(own, model.catalogue["freeplay"], problem)
    assert {m.value("freeplay", "b") for m in found} == {1.5e-3}
    assert {m.value("friction_with_play", "F_h") for m in found} == {60.0, 18.0}
    assert len({m.value("friction_with_play", "z_y") for m in found}) == 3
    assert all(m.value("friction_with_play", "b") == 0.0 for m in found)
    assert handed_over(own, model.catalogue["coulomb_friction"], problem) == []
    assert handed_over(model, model.catalogue["freeplay"], problem) == []
    gap = model.with_effect("freeplay", {"b": 2e-3})
    found = handed_over(gap, model.catalogue["friction_with_play"], problem)
    assert {m.value("friction_with_play", "b") for m in found} == {0.0}
    assert handed_over(model, model.catalogue["friction_with_play"], problem) == []


@pytest.mark.parametrize("seed", [3, 4, 6])
@pytest.mark.parametrize("first", ["friction_with_play", "freeplay"])
def test_friction_behind_a_gap_is_found_by_way_of_either(first, seed):
    """What the first leaves is ten times the noise of 1 N; without handing over, what both leave is so, too."""
    model, problem = brake(seed)
    second = {"friction_with_play", "freeplay"} - {first}
    alone = finished(refit(baseline(model, problem), model.catalogue[first], problem), problem)
    assert np.sqrt(alone.seen) > 5.0
    both = finished(refit(alone, model.catalogue[second.pop()], problem), problem)
    assert np.sqrt(both.seen) < 6.0
    assert both.fit.model.value("freeplay", "b") == pytest.approx(2e-3, rel=0.05)
    assert both.fit.model.value("friction_with_play", "b") < 1e-4
