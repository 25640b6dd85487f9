"""What the data do not determine is no certain name: a value at its bound, or a strength that may be nothing."""

from dataclasses import replace

import numpy as np
import pytest
from er_model_lab.diagnosis.candidates import baseline, refit
from er_model_lab.diagnosis.determined import far, loose
from er_model_lab.diagnosis.investigation import search_effects
from er_model_lab.diagnosis.ties import rivals, tied
from er_model_lab.verbs.diagnose import diagnose
from er_models.files import load_model
from er_models.model import Model
from er_models.prediction import motion, predict
from er_records.in_memory import from_arrays
from lab_help import DT, FORCE_NOISE, GUO, problem_of


def late(force, x):
    """A force that comes 105 ms late, more than the catalogue has a delay for."""
    del x
    return np.concatenate([force[:21], force[:-21]])


@pytest.fixture(scope="module")
def delayed():
    return problem_of(None, {}, seconds=8.0, bent=late)


def test_a_delay_at_its_bound_is_not_determined(delayed):
    model, problem = delayed
    found = refit(baseline(model, problem), model.catalogue["force_delay"], problem)
    assert found.fit.model.value("force_delay", "d") == pytest.approx(0.1)
    assert loose(found, problem) == ("force_delay",)


def test_a_delay_of_many_samples_is_found():
    model, problem = problem_of(
        None, {}, seconds=8.0, bent=lambda force, x: np.concatenate([force[:12], force[:-12]])
    )
    found = refit(baseline(model, problem), model.catalogue["force_delay"], problem)
    assert found.fit.model.value("force_delay", "d") == pytest.approx(0.06, rel=0.01)


@pytest.mark.slow
def test_it_is_no_certain_name(delayed):
    found = search_effects(*delayed)
    assert found.verdict != "missing_effect"


def test_effects_that_cancel_are_not_determined():
    model, problem = problem_of("coulomb_friction", {"F_c": 2.0}, seconds=12.0)
    friction = refit(baseline(model, problem), model.catalogue["coulomb_friction"], problem)
    assert loose(friction, problem) == ()
    both = refit(friction, model.catalogue["force_delay"], problem)
    assert "force_delay" in loose(both, problem)
    assert "coulomb_friction" not in loose(both, problem)


def test_a_neutral_value_at_its_bound_is_determined():
    """Play whose contact is rigid: that the contact gives way by nothing is an answer."""
    model, problem = problem_of("freeplay", {"b": 4e-4, "q": 0.0}, seconds=12.0)
    play = refit(baseline(model, problem), model.catalogue["freeplay"], problem)
    assert isinstance(play.fit.model, Model)
    assert loose(play, problem) == ()


@pytest.mark.parametrize(("bound", "undetermined"), [("high", True), ("low", False)])
def test_an_elastic_way_without_end_is_not_determined(bound, undetermined):
    """A friction whose elastic way is as long as the stroke never slides; one that turns at once is an answer."""
    model, problem = problem_of("coulomb_friction", {"F_c": 2.0}, seconds=12.0)
    friction = refit(baseline(model, problem), model.catalogue["bouc_wen_hysteresis"], problem)
    place = ("bouc_wen_hysteresis", "z_y")
    at = friction.fit.free.index(place)
    theta = friction.fit.theta.copy()
    # but for the last digits, as a fit may end
    theta[at] = getattr(model.catalogue[place[0]].parameter(place[1]), bound) * (1.0 + 1e-12)
    edge = replace(friction.fit, theta=theta, at_bound=np.arange(theta.size) == at)
    assert (place[0] in loose(replace(friction, fit=edge), problem)) is undetermined


@pytest.mark.parametrize("bound", ["high", "low"])
def test_a_place_at_either_bound_is_not_determined(bound):
    """A friction that grows from a place far beyond the stroke on is one that does not grow."""
    model, problem = problem_of("coulomb_friction", {"F_c": 2.0}, seconds=12.0)
    friction = refit(baseline(model, problem), model.catalogue["load_friction"], problem)
    at = friction.fit.free.index(("load_friction", "x_c"))
    theta = friction.fit.theta.copy()
    theta[at] = getattr(model.catalogue["load_friction"].parameter("x_c"), bound)
    edge = replace(friction.fit, theta=theta, at_bound=np.arange(theta.size) == at)
    assert "load_friction" in loose(replace(friction, fit=edge), problem)


def test_a_refinement_at_its_bound_is_determined():
    """A void that takes the pressure at once, as that of vapour does: an answer, not an impossible value."""
    hidden = {"F_v": 8.0, "r": 0.0, "w_s": 2e-4, "s_y": 0.0, "n_g": 30.0}
    model, problem = problem_of("cavitation", hidden, seconds=12.0)
    found = refit(baseline(model, problem), model.catalogue["cavitation"], problem, max_iter=30)
    assert found.fit.model.value("cavitation", "F_v") == pytest.approx(8.0, rel=0.1)
    at = found.fit.free.index(("cavitation", "n_g"))
    edge = replace(found.fit, at_bound=found.fit.at_bound | (np.arange(len(found.fit.free)) == at))
    assert loose(replace(found, fit=edge), problem) == ()


def test_a_zero_of_the_sensor_and_a_preload_are_one_where_a_spring_is_all_they_act_on():
    model, problem = problem_of("preload", {"F_0": 0.6}, seconds=8.0)
    passive = replace(problem, motion=replace(problem.motion, u=np.zeros(problem.motion.n)))
    force = predict(model.with_effect("preload", {"F_0": 0.6}), passive.motion)
    noise = FORCE_NOISE * np.random.default_rng(2).standard_normal(force.size)
    base = baseline(model, replace(passive, force=force + noise))
    found = [
        refit(base, model.catalogue[e], replace(passive, force=force + noise))
        for e in ("preload", "deflection_zero")
    ]
    group = tied(base, sorted(found, key=lambda c: c.mse), passive, 0.05)
    assert {c.name for c in group} == {"preload", "deflection_zero"}
    assert rivals(group[0], group[1], passive)
    zero = next(c for c in found if c.name == "deflection_zero")
    assert not far(zero)
    moved = zero.fit.model.with_effect(
        "deflection_zero", {"x_0": 0.8 * model.bounds("deflection_zero", "x_0")[1]}
    )
    beyond = replace(zero, fit=replace(zero.fit, model=moved))
    assert far(beyond)
    told = tied(base, sorted([beyond, found[0]], key=lambda c: c.mse), passive, 0.05)
    assert [c.name for c in told] == ["preload", "deflection_zero"]


def test_one_tone_gives_no_certain_name_anywhere():
    """Neither the verdict nor any candidate of the JSON."""
    t = np.arange(1600) * DT
    w, rng = 2.0 * np.pi * 1.5, np.random.default_rng(1)
    x, v, a = 0.01 * np.sin(w * t), 0.01 * w * np.cos(w * t), -0.01 * w**2 * np.sin(w * t)
    u, model = np.repeat([0.0, 0.1, 0.2, 0.3], 400), load_model(GUO)
    truth = model.with_effect("coulomb_friction", {"F_c": 3.0})
    force = predict(truth, motion(DT, x, v, u, a)) + FORCE_NOISE * rng.standard_normal(t.size)
    data = from_arrays(t=t, deflection=x, deflection_velocity=v, duty=u, damper_force=force)
    found = diagnose(data, model, anyway=True).to_dict()
    assert found["verdict"] != "missing_effect"
    assert "present" not in {e["status"] for e in found["candidates"]}
    named = [e for e in found["candidates"] if e["effect"] in found["effects"]]
    assert named
    assert all(e["status"] == "confounded" for e in named)
