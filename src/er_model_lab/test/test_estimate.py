"""Estimates: the bias of noisy motion is taken off, and deviations hold where forces jump."""

from dataclasses import replace

import numpy as np
import pytest
from er_model_lab.fitting.deviations import with_deviations
from er_model_lab.fitting.estimate import (
    MOST_BIAS,
    _unless_astray,
    as_far_as_straight,
    estimated,
    settled,
    stopped,
    trusted,
)
from er_model_lab.fitting.fit import Box, fit
from er_model_lab.problem.prepare import prepare
from er_models.model import Model
from er_models.prediction import motion, predict
from er_models.scales import Scales
from er_records.dataset import Dataset
from er_records.record import Record
from lab_help import DT, imposed, problem_of

SCALES = Scales(force=30.0, deflection=0.01, velocity=0.15, duty=0.3)

TRUE = {"F_c": 1.0, "v_0": 0.003}


def errors(model, of):
    """Errors of the friction's parameters in standard deviations."""
    values, sds = model.effects["coulomb_friction"], of.deviations["coulomb_friction"]
    return np.array([(values[q] - TRUE[q]) / sds[q] for q in TRUE])


def test_noise_of_the_motion_no_longer_widens_the_friction():
    before, after = [], []
    for seed in range(1, 7):
        model, problem = problem_of(
            "coulomb_friction", TRUE, seed=seed, accelerometers=False, blur=10.0
        )
        fitted = fit(model.with_effect("coulomb_friction"), problem, max_iter=30)
        plain, better = with_deviations(fitted, problem), estimated(fitted, problem, seed)
        before.append(errors(plain, plain)[1])
        after.append(errors(better, better)[1])
    assert np.mean(before) > 1.5
    assert abs(np.mean(after)) < 0.6 * np.mean(before)


def test_where_longer_steps_lead_astray_the_fit_stays():
    """Contacts switch elsewhere in them: what is found there counts as the usual steps see it."""
    model, problem = problem_of("coulomb_friction", TRUE, seconds=12.0)
    fitted = fit(model.with_effect("coulomb_friction"), problem, max_iter=30)
    told = 0.5 * fitted.residual
    for share, stays in ((1.0, False), (1.5, True)):
        values = {q: share * v for q, v in TRUE.items()}
        other = fitted.model.with_effect("coulomb_friction", values)
        rough = replace(fitted, residual=1.2 * fitted.residual)
        seen = _unless_astray(replace(fitted, model=other, residual=told), rough, problem)
        assert (seen is rough) is stays
        if not stays:
            left = problem.force - problem.predict(other)
            np.testing.assert_allclose(seen.residual, left)


def test_of_a_bias_beyond_trust_values_that_make_up_for_each_other_are_taken_together():
    """Each cut by itself, the sum of two frictions would move though the data tell it."""
    sd, alike = np.array([1.0, 1.0, 0.1]), -1.0 + 1e-6
    covariance = np.array([[1.0, alike, 0.0], [alike, 1.0, 0.0], [0.0, 0.0, 0.01]])
    taken = trusted(np.array([30.0, -29.99, 0.05]), covariance)
    assert taken[0] == pytest.approx(MOST_BIAS * sd[0], rel=0.01)
    assert abs(taken[0] + taken[1]) < MOST_BIAS * np.sqrt(2.0 * (1.0 + alike))
    assert taken[2] == pytest.approx(0.05)
    unknown = np.full((3, 3), np.nan)
    unknown[2, 2] = 0.01
    assert trusted(np.array([30.0, -29.9, 0.05]), unknown).tolist() == [
        0.0,
        0.0,
        pytest.approx(0.05),
    ]


def test_where_a_bound_stops_a_value_the_others_follow():
    """Two frictions of one width make the force of their sum; the second one cannot fall below nothing."""
    model, problem = problem_of("coulomb_friction", TRUE, seed=2)
    free = (("passive", "c0"), ("coulomb_friction", "F_c"), ("stribeck_friction", "F_c"))
    both = model.with_effect("coulomb_friction").with_effect("stribeck_friction")
    box, rng = Box(both, free, problem.scales), np.random.default_rng(0)
    damping, friction = rng.standard_normal((2, 500))
    j, theta = np.stack([damping, friction, friction], axis=1), np.array([1.0, 0.2, 0.1])
    inner, step = np.full(3, True), np.array([0.05, 0.3, -0.3])
    found = stopped(theta, step, j, inner, box)
    assert found.tolist() == pytest.approx([1.05, 0.3, 0.0])
    assert stopped(theta, 0.1 * step, j, inner, box).tolist() == pytest.approx([1.005, 0.23, 0.07])


def test_a_bias_that_the_error_would_feel_is_not_taken():
    """Be it ever so straight: where a bound stops one of two values that make up for each other, none can follow."""
    model, problem = problem_of("coulomb_friction", TRUE, seed=2)
    fitted = fit(model.with_effect("coulomb_friction"), problem, max_iter=30)
    box = Box(fitted.model, fitted.free, problem.scales)
    along = np.arange(fitted.theta.size) == fitted.free.index(("passive", "c0"))
    near, far = (fitted.theta + share * fitted.theta * along for share in (1e-3, 3.0))
    asked = (fitted, fitted.jacobian, problem, box)
    assert as_far_as_straight([near, far], *asked) is near
    assert as_far_as_straight([far], *asked) is fitted.theta


def test_estimates_of_two_frictions_leave_hardly_more_than_the_fit():
    """A positioning drive: a high breakaway along a motion that is known badly, beside a Coulomb friction."""
    values = {"F_c": 0.05, "F_s": 9.0, "v_s": 0.02, "v_0": 0.004}
    model, problem = problem_of(
        "stribeck_friction", values, seed=5, accelerometers=False, blur=10.0
    )
    both = model.with_effect("coulomb_friction", {"F_c": 1.0, "v_0": 0.01})
    fitted = fit(both.with_effect("stribeck_friction", values), problem, max_iter=40)
    better = estimated(fitted, problem, 0)
    left = np.sqrt(np.mean((problem.force - problem.predict(better))[problem.train] ** 2))
    assert left < 1.3 * np.sqrt(fitted.mse(problem.train))


def test_clean_motion_is_left_where_it_is():
    model, problem = problem_of("coulomb_friction", TRUE, seed=2, blur=0.05)
    fitted = fit(model.with_effect("coulomb_friction"), problem, max_iter=30)
    plain, better = with_deviations(fitted, problem), estimated(fitted, problem, 0)
    assert np.all(np.abs(errors(plain, plain) - errors(better, plain)) < 0.3)
    assert np.all(np.abs(errors(better, better)) < 3.0)


def test_a_gap_gets_a_deviation_of_its_own_size():
    model, problem = problem_of("freeplay", {"b": 2.3e-5}, seed=6)
    fitted = fit(model.with_effect("freeplay", {"b": 2.0e-5}), problem)
    better = estimated(fitted, problem, 0)
    b, sd = better.value("freeplay", "b"), better.deviations["freeplay"]["b"]
    assert 1e-8 < sd < 4e-6
    assert abs(b - 2.3e-5) < 4.0 * sd


def test_a_value_at_its_bound_has_no_deviation():
    model, problem = problem_of("coulomb_friction", TRUE, seed=3)
    fitted = fit(model.with_effect("duty_dead_band", {"u_0": 0.0}), problem)
    better = estimated(fitted, problem, 0)
    if better.value("duty_dead_band", "u_0") == 0.0:
        assert better.deviations["duty_dead_band"]["u_0"] == np.inf
    assert np.isfinite(better.deviations["passive"]["k0"])


def test_the_same_seed_gives_the_same_values():
    model, problem = problem_of("coulomb_friction", TRUE, seed=4, seconds=12.0)
    fitted = fit(model.with_effect("coulomb_friction"), problem)
    assert estimated(fitted, problem, 5).effects == estimated(fitted, problem, 5).effects
    assert estimated(fitted, problem, 5).effects != estimated(fitted, problem, 6).effects


PLAY = {"b": 4e-5, "c_p": 120.0}


def test_a_play_is_found_in_its_own_valley_and_its_deviations_hold():
    model, problem = problem_of("piston_play", PLAY, seed=1)
    begun = {q: 1.25 * value for q, value in PLAY.items()}
    fitted = fit(model.with_effect("piston_play", begun), problem)
    better = estimated(fitted, problem, 0)
    sds = better.deviations["piston_play"]

    def off(found):
        return [abs(found.value("piston_play", q) - PLAY[q]) / sds[q] for q in PLAY]

    assert all(sds[q] < 0.2 * PLAY[q] for q in PLAY)
    assert max(off(fitted.model)) > 2.0
    assert max(off(better)) < 3.0


def test_a_parameter_that_moves_nothing_is_not_known_exactly() -> None:
    """The pseudo-inverse gives it a deviation of zero."""
    from types import SimpleNamespace
    from typing import Any, cast

    from er_model_lab.fitting.deviations import standard_deviations

    rng = np.random.default_rng(0)
    fitted = SimpleNamespace(
        model=Model("made", {}, SCALES), theta=np.zeros(3), scale=np.ones(3), at_bound=np.array([False, False, True]),
        free=(("passive", "k0"), ("passive", "c0"), ("coulomb_friction", "F_c")),
        residual=rng.standard_normal(1000),
        jacobian=np.stack([rng.standard_normal(1000), np.zeros(1000), np.ones(1000)], axis=1),
    )  # fmt: skip
    problem = SimpleNamespace(train=np.full(1000, True), second=200)
    told = standard_deviations(cast(Any, fitted), cast(Any, problem))
    assert 0.01 < told[0] < 0.1
    assert np.isinf(told[1:]).all()


@pytest.mark.parametrize("ninth", [0.0, 3e-9])
def test_what_two_levels_of_the_duty_do_not_tell_stays_as_it_was(ninth):
    """Exponent, yield force and remanence make up for each other; a level between them is predicted all the same.

    Two directions say nothing, and which two the solver takes hangs on the ninth digit: all of them count.
    """
    values = {
        "passive": {"k0": 200.0, "c0": 80.0},
        "bingham_yield": {"sigma": 20.0, "beta": 1.2, "v_0": 0.003},
    }
    given = Model("mr", values, SCALES)
    rng, n = np.random.default_rng(1), 4000
    x, v, a, _ = imposed(rng, n)
    u = 0.3 * np.repeat(rng.integers(0, 2, n // 100), 100).astype(float)
    truth = given.with_effect("remanence", {"r": 0.08, "s": 0.6})
    force = predict(truth, motion(DT, x, v, u, a)) + 0.05 * rng.standard_normal(n)
    channels = {
        "deflection": x, "deflection_velocity": v, "duty": u, "damper_force": (1.0 + ninth) * force
    }  # fmt: skip
    problem = prepare(Dataset.of([Record("made", np.arange(n) * DT, channels)]))
    begun = {**values, "bingham_yield": {"sigma": 15.0, "beta": 0.6, "v_0": 0.003}}
    off = fit(Model("mr", begun, SCALES).with_effect("remanence"), problem, max_iter=40)
    kept = settled(off, given, problem)
    assert kept.mse(problem.train) < 1.001 * off.mse(problem.train)
    middle = motion(DT, x, v, 0.0 * u + 0.15, a)
    errors = [np.std(predict(f.model, middle) - predict(truth, middle)) for f in (off, kept)]
    assert errors[1] < 0.3 * errors[0]
    assert kept.model.value("bingham_yield", "beta") == pytest.approx(1.2, abs=0.02)
    told, whole = (
        m.deviations["bingham_yield"]["beta"]
        for m in (estimated(off, problem, 0, given), with_deviations(off, problem))
    )
    assert told >= whole
    sure = fit(given, problem)
    again = settled(sure, given, problem).model.value("passive", "c0")
    assert again == pytest.approx(sure.model.value("passive", "c0"), rel=1e-3)
