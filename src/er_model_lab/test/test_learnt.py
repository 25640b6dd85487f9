"""A fitted model knows what it was fitted to, and data beyond that are told apart, with the error there."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from er_model_lab.diagnosis.noise_floor import noise_floor
from er_model_lab.fitting.data_reach import (
    GAP,
    REACH,
    beyond,
    duty_gap,
    gap_note,
    held_out_beyond,
    reach,
    within_learnt,
)
from lab_help import problem_of


@pytest.fixture(scope="module")
def known():
    """A model whose history names the reach of a measurement, and the problem of it."""
    model, problem = problem_of(None, {}, seconds=12.0)
    return replace(model, history=({"added": []}, {REACH: reach(problem)})), problem


def larger(problem, **factors):
    """The same measurement, a channel of the motion (or `power`: the force) times a factor."""
    force = problem.force * factors.pop("power", 1.0)
    moved = {k: getattr(problem.motion, k) * f for k, f in factors.items()}
    return replace(problem, force=force, motion=replace(problem.motion, **moved))


def test_the_reach_is_that_of_the_training_samples(known):
    _, problem = known
    found, train = reach(problem), problem.train
    assert found["deflection"] == [problem.motion.x[train].min(), problem.motion.x[train].max()]
    assert found["duty"] == [0.0, 0.3]
    power = np.mean(np.abs(problem.force * problem.motion.v))
    assert found["power"] == pytest.approx([power, power])


def test_what_it_was_fitted_to_is_not_beyond(known):
    model, problem = known
    assert beyond(model, problem, problem.force) is None
    assert beyond(replace(model, history=()), larger(problem, x=9.0), problem.force) is None


@pytest.mark.parametrize(
    ("channel", "name"), [("x", "deflection"), ("v", "velocity"), ("u", "duty")]
)
def test_larger_motion_is_beyond_where_it_is_larger(known, channel, name):
    model, problem = known
    factor = {"x": 2.0, "v": 1.3, "u": 2.0}[channel]
    larger_problem = larger(problem, **{channel: factor})
    low, high = reach(problem)[name]
    y, margin = getattr(larger_problem.motion, channel), 0.1 * (high - low)
    outside = problem.used & ((y < low - margin) | (y > high + margin))
    residual = np.where(outside, 3.0, 0.5)
    found = beyond(model, larger_problem, residual)
    assert found is not None
    assert found.matters
    assert found.share == pytest.approx(outside.sum() / problem.used.sum())
    assert name in found.reach
    assert found.reach[name][1] == (low, high)
    assert (found.rms_beyond, found.rms_inside) == pytest.approx((3.0, 0.5))
    assert "3 N there and 0.5 N elsewhere" in found.note(
        "these data", "what 'better' was fitted to"
    )
    assert f"({name} " in found.note("these data", "what 'better' was fitted to")


def test_more_power_is_named_and_less_is_not(known):
    model, problem = known
    found = beyond(model, larger(problem, power=2.0), problem.force)
    assert found is not None
    assert found.share == 0.0
    assert found.matters
    assert list(found.reach) == ["power"]
    assert "(power up to " in found.note("these data", "what 'better' was fitted to")
    assert "%" not in found.note("these data", "what 'better' was fitted to")
    assert beyond(model, larger(problem, power=1.4), problem.force) is None
    assert beyond(model, larger(problem, power=0.1), problem.force) is None


def test_a_few_samples_count_where_they_carry_the_error(known):
    model, problem = known
    x = problem.motion.x.copy()
    at = np.flatnonzero(problem.used)[:3]
    x[at] = 1.0
    beside = replace(problem, motion=replace(problem.motion, x=x))
    quiet = np.ones(x.size)
    loud = quiet.copy()
    loud[at] = 100.0
    assert not beyond(model, beside, quiet).matters
    assert beyond(model, beside, loud).matters


def test_held_out_data_beyond_what_was_learnt_are_told_and_are_no_noise(known):
    _, problem = known
    fast = problem.motion.v.copy()
    rows = np.flatnonzero(problem.held_out)
    fast[rows[: rows.size // 3]] *= 5.0
    beyond_it = replace(problem, motion=replace(problem.motion, v=fast))
    outside = problem.held_out & ~within_learnt(beyond_it)
    assert 0.1 * rows.size < outside.sum() < 0.4 * rows.size
    rng = np.random.default_rng(0)
    residual = rng.standard_normal(fast.size) * np.where(outside, 20.0, 0.5)
    found = held_out_beyond(beyond_it, residual)
    assert found is not None
    assert found.share == pytest.approx(outside.sum() / rows.size)
    assert (found.rms_beyond, found.rms_inside) == pytest.approx((20.0, 0.5), rel=0.2)
    assert "the held-out data go beyond those learnt from (velocity" in found.note(
        "the held-out data", "those learnt from"
    )
    assert held_out_beyond(problem, residual) is None
    assert np.array_equal(within_learnt(problem), problem.held_out)
    left = SimpleNamespace(residual=residual, fit=SimpleNamespace(residual=residual), mse=1.0)
    null = SimpleNamespace(
        input_square=np.zeros(fast.size), bursts=(0.0,), outputs=1, input_error=0.0
    )
    assert noise_floor(beyond_it, left, null, 0).held_out < 0.7


def with_duty(problem, levels):
    """The same measurement under duties of these levels, each for as long."""
    rows = np.arange(problem.force.size) * len(levels) // problem.force.size
    return replace(problem, motion=replace(problem.motion, u=np.asarray(levels)[rows]))


@pytest.mark.parametrize(
    ("levels", "gap"),
    [
        ((0.3,), None),
        ((0.0, 0.3), (0.03, 0.27)),
        ((0.0, 0.15, 0.3), None),
        ((0.0, 0.03, 0.3), (0.06, 0.27)),
        (np.linspace(0.0, 0.3, 30), None),
    ],
)
def test_a_gap_of_the_duty_is_where_no_level_is(levels, gap):
    found = duty_gap(np.repeat(levels, 100))
    assert (found is None) == (gap is None)
    if gap:
        assert found == pytest.approx(gap)


def test_duties_between_two_levels_are_beyond_what_was_learnt(known):
    model, problem = known
    two = with_duty(problem, (0.0, 0.3, 0.0, 0.3))
    fitted = replace(model, history=({REACH: reach(two)},))
    assert reach(two)[GAP] == pytest.approx([0.03, 0.27])
    assert beyond(fitted, two, problem.force) is None
    steps = with_duty(problem, (0.0, 0.1, 0.2, 0.3))
    between = problem.used & (steps.motion.u > 0.05) & (steps.motion.u < 0.25)
    found = beyond(fitted, steps, np.where(between, 3.0, 0.5))
    assert found.share == pytest.approx(between.sum() / problem.used.sum())
    assert (found.rms_beyond, found.rms_inside) == pytest.approx((3.0, 0.5))
    said = found.note("these data", "what 'better' was fitted to")
    assert "(duty 0.1 to 0.2, fitted to none between 0.03 and 0.27)" in said
    one = beyond(fitted, with_duty(problem, (0.2,)), problem.force)
    assert "(duty 0.2, fitted to none" in one.note("these data", "what 'better' was fitted to")
    assert beyond(model, steps, problem.force) is None  # it was fitted to three levels
    held = replace(two, motion=replace(two.motion, u=np.where(two.held_out, 0.1, two.motion.u)))
    assert not within_learnt(held).any()
    assert "hardly ever between 0.03 and 0.27" in gap_note(model, two)[0]
    assert gap_note(model, steps) == ()
    passive = replace(model, effects={"passive": model.effects["passive"]})
    assert gap_note(passive, two) == ()
