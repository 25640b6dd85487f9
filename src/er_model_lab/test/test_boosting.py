"""Boosted trees: they come out as those of a library of their own."""

import numpy as np
import pytest
from er_model_lab.diagnosis.boosting import LEAST, LEAVES, RATE, RIDGE, TREES, boosted_trees


def measured(n=900, seed=0):
    """Inputs (n, 4), one of few values and one that never changes, and a target (n,)."""
    rng = np.random.default_rng(seed)
    inputs = np.stack([
        rng.standard_normal(n).cumsum(), rng.choice([0.0, 0.1, 0.3], n), np.ones(n), rng.standard_normal(n),
    ], axis=1)  # fmt: skip
    target = np.tanh(inputs[:, 0]) * inputs[:, 1] + 0.02 * inputs[:, 3] ** 2
    return inputs, target + 0.05 * rng.standard_normal(n)


def test_they_are_those_of_scikit_learn():
    ensemble = pytest.importorskip("sklearn.ensemble")
    theirs = ensemble.HistGradientBoostingRegressor(
        max_iter=TREES, learning_rate=RATE, max_leaf_nodes=LEAVES, min_samples_leaf=LEAST, l2_regularization=RIDGE,
    )  # fmt: skip
    known, unseen = measured(), measured(seed=1)[0]
    theirs.fit(*known)
    ours = boosted_trees(*known)
    np.testing.assert_allclose(ours.predict(unseen), theirs.predict(unseen), atol=1e-7)


def test_no_leaf_is_smaller_than_it_may_be():
    inputs, target = measured(n=2 * LEAST - 1)
    assert np.ptp(boosted_trees(inputs, target).predict(inputs)) == 0.0


def test_where_nothing_varies_the_mean_is_predicted():
    found = boosted_trees(np.zeros((100, 2)), np.arange(100.0))
    np.testing.assert_allclose(found.predict(np.ones((3, 2))), 49.5)
