"""Stretches, roles, response times and visibility, each on what is known exactly."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from er_model_lab.fitting.fit import Box, fit
from er_model_lab.identification.law import follow_table, quadratic, response_time
from er_model_lab.identification.levels import Table, _LevelsFit, response_times
from er_model_lab.identification.part import among
from er_model_lab.identification.procedure import learn_from_all
from er_model_lab.identification.roles import roles, static
from er_model_lab.identification.stretches import levels, stretches
from er_model_lab.identification.visibility import imitators, visibility
from er_model_lab.problem.prepare import prepare
from er_model_lab.problem.problem import Problem
from er_models.files import load_model
from er_models.model import Model
from er_models.prediction import Motion, motion, predict
from er_records.dataset import Dataset
from er_records.record import Record

DAMPERS = Path(__file__).parents[3] / "config" / "dampers"
DT = 0.005
DUTY = np.array([0.1, 0.15, 0.2, 0.25, 0.3])
TABLE_1_4 = np.array([0.0137, 0.0221, 0.0365, 0.055, 0.0631])


def damper(name: str) -> Model:
    return load_model(DAMPERS / f"{name}.yaml")


def moved(duty: np.ndarray) -> Motion:
    """Two sines under a duty given sample by sample."""
    t = np.arange(duty.size) * DT
    x = 0.006 * np.sin(2 * np.pi * 1.1 * t) + 0.002 * np.sin(2 * np.pi * 3.7 * t)
    v = np.gradient(x, DT)
    return motion(DT, x, v, duty)


def problem_of(model: Model, duty: np.ndarray) -> Problem:
    """Records without noise: force of the model itself, all samples to learn from."""
    m = moved(duty)
    force = predict(model, m)
    channels = {"deflection": m.x, "deflection_velocity": m.v, "duty": duty, "damper_force": force}
    made = prepare(Dataset.of([Record("r", np.arange(m.n) * DT, channels)]))
    return learn_from_all(replace(made, motion=m), scored=0)


def stairs(*duties: float, seconds: float = 2.0) -> np.ndarray:
    return np.repeat(duties, round(seconds / DT))


def test_stretches_end_where_the_duty_leaves_its_first_value() -> None:
    rng = np.random.default_rng(3)
    duty = np.concatenate(
        [
            np.zeros(500),
            0.2 + 0.0005 * rng.uniform(-1, 1, 300),
            np.linspace(0.2, 0.3, 100),
            np.full(90, 0.3),
        ]
    )
    m = replace(moved(duty), starts=np.array([0, 200, duty.size]))
    found = stretches(m)
    assert found[:2] == [(0, 200), (200, 500)]
    assert found[2][0] == 500
    assert 800 <= found[2][1] <= 803
    assert [i for i, _ in found[1:]] == [j for _, j in found[:-1]]
    assert found[-1][1] == duty.size
    for i, j in found:
        assert np.all(np.abs(duty[i:j] - duty[i]) <= 0.005 * 0.3)


def test_levels_join_equal_duties_cut_what_settles_and_keep_off_apart() -> None:
    duty = stairs(0.0, 0.2, 0.0, 0.004, 0.205, 0.3)
    m, use = moved(duty), np.ones(duty.size, bool)
    use[:100] = False
    found = levels(m, use, settle=0.5)
    assert [level.duty for level in found] == pytest.approx([0.0, 0.004, 0.2025, 0.3])
    assert [int(level.rows.sum()) for level in found] == [2 * 300, 300, 2 * 300, 300]
    assert not found[0].rows[:100].any()
    assert levels(m, use, settle=1.8) == []


@pytest.mark.parametrize(
    ("name", "linear", "shape", "response"),
    [
        ("inove_guo", "k0 c0", "f_c k1 c1", "tau"),
        ("inove_bingham", "k0 c0", "sigma beta", ""),
        ("inove_guo_complete", "k0_c c0_c k0_r c0_r", "f_c_c k1_c c1_c f_c_r k1_r c1_r",
         "tau_1 tau_2 tau_3 tau_4 tau_5"),
    ],
)  # fmt: skip
def test_roles_follow_what_a_parameter_changes(
    name: str, linear: str, shape: str, response: str
) -> None:
    model = damper(name)
    who = roles(model, problem_of(model, stairs(0.0, 0.3)))
    for free, names in ((who.linear, linear), (who.shape, shape), (who.response, response)):
        assert [n for _, n in free] == names.split()


def test_roles_see_other_effects_and_a_yield_force_that_is_off() -> None:
    model = damper("inove_guo").with_effect("coulomb_friction").with_effect("dead_time")
    model = replace(
        model, effects={**model.effects, "guo_yield": {**model.effects["guo_yield"], "f_c": 0.0}}
    )
    who = roles(model, problem_of(damper("inove_guo"), stairs(0.0, 0.3)))
    assert ("coulomb_friction", "F_c") in who.linear
    assert {n for _, n in who.shape} == {"f_c", "k1", "c1"}
    assert all(e != "dead_time" for e, _ in (*who.linear, *who.shape, *who.response))


def test_response_times_of_the_levels_are_those_of_the_table() -> None:
    truth = damper("inove_guo_tau_table")
    problem = problem_of(truth, stairs(0.1, 0.15, 0.2, 0.25, 0.3))
    found = levels(problem.motion, problem.train, 0.5)
    start = static(truth)
    wrong = {k: dict(v) for k, v in start.effects.items()}
    for name, factor in (("f_c", 0.7), ("k1", 1.5), ("c1", 0.6)):
        wrong["guo_yield"][name] *= factor
    shape = roles(truth, problem).shape
    table = response_times(replace(start, effects=wrong), shape, problem, found)
    np.testing.assert_allclose(table.duty, DUTY)
    np.testing.assert_allclose(table.tau, TABLE_1_4, rtol=2e-3)
    assert table.model.value("guo_yield", "c1") == pytest.approx(492.6448, rel=5e-3)
    assert "response" not in table.model.effects


def table_of(tau: np.ndarray, sd: float = 1e-4) -> Table:
    return Table(DUTY, tau, sd**2 * np.eye(DUTY.size), static(damper("inove_guo")), 0.1)


def test_the_quadratic_through_a_table_is_its_least_squares() -> None:
    found = quadratic(table_of(TABLE_1_4))
    assert found is not None
    expected = np.polyfit(DUTY, TABLE_1_4, 2)[::-1]
    np.testing.assert_allclose(found.value, expected, rtol=1e-6)
    left = TABLE_1_4 - np.polynomial.polynomial.polyval(DUTY, expected)
    assert found.chi2 == pytest.approx(float(np.sum((left / 1e-4) ** 2)), rel=1e-6)
    basis = np.vander(DUTY, 3, increasing=True)
    np.testing.assert_allclose(found.covariance, 1e-8 * np.linalg.inv(basis.T @ basis), rtol=1e-4)
    assert quadratic(replace(table_of(TABLE_1_4), covariance=np.full((5, 5), np.nan))) is None


@pytest.mark.parametrize(
    ("name", "tau", "least"),
    [
        ("inove_guo", np.full(5, 0.05), 1e-6),
        ("inove_guo_tau_table", 0.4 * TABLE_1_4, 1e-6),
        ("inove_guo_tau_quadratic", 0.004 + 0.3 * DUTY - 0.2 * DUTY**2, 1e-6),
    ],
)
def test_a_law_follows_its_table(name: str, tau: np.ndarray, least: float) -> None:
    model = damper(name)
    problem = problem_of(model, stairs(0.1, 0.3))
    assert np.max(np.abs(response_time(model, DUTY) - tau)) > 0.005
    followed = follow_table(model, roles(model, problem).response, table_of(tau), problem)
    np.testing.assert_allclose(response_time(followed, DUTY), tau, atol=least)


def test_a_level_of_no_deviation_does_not_bend_the_law() -> None:
    """One that ended at its bound: without a deviation it would outweigh all others."""
    model = damper("inove_guo_tau_quadratic")
    problem = problem_of(model, stairs(0.1, 0.3))
    tau = 0.004 + 0.3 * DUTY - 0.2 * DUTY**2
    table = table_of(np.append(tau[:4], 1e-6))
    table.covariance[4, :] = table.covariance[:, 4] = np.nan
    free = roles(model, problem).response
    followed = follow_table(model, free, table, problem)
    np.testing.assert_allclose(response_time(followed, DUTY), tau, atol=1e-6)
    unknown = replace(table_of(tau), covariance=np.full((5, 5), np.nan))
    followed = follow_table(model, free, unknown, problem)
    np.testing.assert_allclose(response_time(followed, DUTY), tau, atol=1e-6)


def test_a_response_time_at_either_bound_has_no_deviation() -> None:
    truth = damper("inove_guo_tau_table")
    problem = problem_of(truth, stairs(0.1, 0.2, 0.3))
    shape = roles(truth, problem).shape
    box = Box(
        static(truth).with_effect("response", {"tau": 0.03}),
        (*shape, ("response", "tau")),
        problem.scales,
    )
    levels_fit = _LevelsFit(box, problem, levels(problem.motion, problem.train, 0.5))
    found = levels_fit.start()
    found[-3:] = box.low[-1], found[-2], box.high[-1]
    assert np.isfinite(levels_fit.table(found).sd).tolist() == [False, True, False]


def test_what_a_table_leaves_open_stays_as_it_is() -> None:
    model = damper("inove_guo_tau_table")
    problem = problem_of(model, stairs(0.1, 0.3))
    ends = Table(DUTY[[0, 4]], np.array([0.02, 0.07]), 1e-8 * np.eye(2), static(model), 0.1)
    followed = follow_table(model, roles(model, problem).response, ends, problem)
    values = followed.effects["response_table"]
    assert (values["tau_1"], values["tau_5"]) == pytest.approx((0.02, 0.07))
    for k in (2, 3, 4):
        assert values[f"tau_{k}"] == model.value("response_table", f"tau_{k}")


def noisy(problem: Problem, sd: float, seed: int) -> Problem:
    noise = sd * np.random.default_rng(seed).standard_normal(problem.motion.n)
    return replace(problem, force=problem.force + noise)


def test_visibility_is_the_fisher_information_of_a_linear_fit() -> None:
    model = damper("inove_guo").without_effect("response").without_effect("guo_yield")
    model = model.with_effect("preload", {"F_0": 0.05})
    problem = noisy(problem_of(model, stairs(0.0, 0.0, seconds=20.0)), 0.2, 1)
    found = fit(model, problem, tol=1e-10)
    seen = visibility(found, problem)
    m, rows = problem.motion, problem.train
    x = np.stack([m.x[rows], m.v[rows], np.ones(rows.sum())], axis=1)
    exact = 0.2**2 * np.linalg.inv(x.T @ x)
    np.testing.assert_allclose(
        np.sqrt(np.diag(seen.covariance)), np.sqrt(np.diag(exact)), rtol=0.35
    )
    across = 1.0 / np.sqrt(np.diag(np.linalg.inv(x.T @ x / len(x))))
    values = np.abs(found.theta * found.scale)
    np.testing.assert_allclose(seen.visible, 0.1 * values * across, rtol=0.01)
    assert seen.weak.tolist() == [False, False, True]
    assert not seen.unknown.any()


def test_two_parameters_that_do_the_same_are_unknown_and_imitate_one_another() -> None:
    model = damper("inove_bingham")
    problem = noisy(problem_of(model, stairs(0.2, 0.2)), 0.1, 2)
    found = fit(model, problem, tol=1e-8)
    seen = visibility(found, problem)
    names = [n for _, n in found.free]
    unknown = {n for n, u in zip(names, seen.unknown, strict=True) if u}
    assert unknown == {"sigma", "beta"}
    assert imitators(found, problem, names.index("beta")) == (("bingham_yield", "sigma"),)
    assert imitators(found, problem, names.index("k0")) == ()


def test_a_parameter_the_force_does_not_feel_is_unknown() -> None:
    model = damper("inove_guo")
    problem = noisy(problem_of(model, stairs(0.0, 0.0)), 0.1, 3)
    off = among(problem, np.ones(problem.motion.n, bool))
    found = fit(model, off)
    seen = visibility(found, off)
    unknown = {n for (_, n), u in zip(found.free, seen.unknown, strict=True) if u}
    assert unknown == {"f_c", "k1", "c1", "tau"}
