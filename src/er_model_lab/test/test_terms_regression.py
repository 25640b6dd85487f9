"""The equations of a term together with the parameters of its model."""

import numpy as np
import pytest
from er_model_lab.terms.regression import normal


def test_a_parameter_without_effect_is_told_nothing_and_stays():
    """Of the field in a friction, without a duty: its derivative is zero, and so was a pivot of every solution."""
    rng = np.random.default_rng(2)
    j, block = rng.normal(size=(400, 2)), np.repeat(np.arange(8), 50)
    left = 3.0 * j[:, 0] + rng.normal(size=400)
    idle = np.column_stack([j[:, 0], np.zeros(400), j[:, 1]])
    for columns in (idle, j):
        equations = normal(columns, np.empty((400, 0)), left, block)
        penalty = equations.penalty(np.empty((0, 0)), 0.0)
        found, losses = equations.solved(penalty), equations.judged(penalty)
        assert np.all(np.isfinite(losses))
    alone = equations.mean(losses)
    equations = normal(idle, np.empty((400, 0)), left, block)
    penalty = equations.penalty(np.empty((0, 0)), 0.0)
    assert equations.solved(penalty) == pytest.approx([found[0], 0.0, found[1]])
    assert equations.mean(equations.judged(penalty)) == pytest.approx(alone)
