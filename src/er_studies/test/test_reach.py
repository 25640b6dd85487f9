"""What records leave to those who know more than the model: constants and the force's past."""

from types import SimpleNamespace

import numpy as np
import pytest
from er_studies.reach import _ago, _by_duty, _by_record, _trees

STARTS = np.array([0, 300, 600, 900])


@pytest.fixture
def problem():
    """Three records of one steady duty each, the last held out at the duty of the second."""
    rng = np.random.default_rng(1)
    level = np.repeat([0, 1, 2], 300)
    duty = np.array([0.0, 0.5, 0.5])[level]
    force = np.array([1.0, 2.0, 6.0])[level] + 0.01 * rng.standard_normal(900)
    held_out = level == 2
    return SimpleNamespace(
        motion=SimpleNamespace(u=duty, starts=STARTS, dt=0.01), force=force, train=~held_out, held_out=held_out,
        used=np.ones(900, bool),
    )  # fmt: skip


def test_a_constant_of_the_duty_is_learnt_and_one_of_the_record_is_its_own(problem):
    of_duty, of_record = _by_duty(problem, problem.force), _by_record(problem, problem.force)
    assert of_duty[[0, 300, 600]] == pytest.approx([1.0, 2.0, 2.0], abs=0.01)
    assert of_record[[0, 300, 600]] == pytest.approx([1.0, 2.0, 6.0], abs=0.01)


def test_the_past_of_a_record_is_its_own(problem):
    past = _ago(problem, 0.02)
    np.testing.assert_array_equal(past[302:600], problem.force[300:598])
    assert past[600] == past[601] == problem.force[600]


def test_trees_learn_from_training_records_alone(problem):
    told = _trees(problem, problem.force, problem.motion.u[:, None])
    assert told[[10, 310, 610]] == pytest.approx([1.0, 2.0, 2.0], abs=0.05)
