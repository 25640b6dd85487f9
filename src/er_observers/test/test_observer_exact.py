"""Definiteness in fractions: agrees with eigenvalues, and decides where they cannot."""

from __future__ import annotations

import numpy as np
import pytest
from er_models.exact import exact, is_positive_definite


@pytest.mark.parametrize("seed", range(20))
def test_agrees_with_eigenvalues(seed: int) -> None:
    """Random symmetric matrices, some definite, some not."""
    random = np.random.default_rng(seed)
    root = random.normal(size=(5, 5))
    matrix = root @ root.T - random.uniform(0.0, 0.5) * np.eye(5)
    matrix = 0.5 * (matrix + matrix.T)
    assert is_positive_definite(exact(matrix)) == bool(np.linalg.eigvalsh(matrix)[0] > 0.0)


def test_decides_where_doubles_cannot() -> None:
    """One unit in the last place apart from singular, on either side."""
    for nudge, expected in ((np.spacing(1.0), True), (0.0, False), (-np.spacing(0.5), False)):
        matrix = np.array([[1.0, 1.0], [1.0, 1.0 + nudge]])
        assert is_positive_definite(exact(matrix)) is expected


def test_asymmetric_matrices_are_refused() -> None:
    """Definiteness of the symmetric part alone would be another statement."""
    assert not is_positive_definite(exact([[1.0, 0.1], [0.0, 1.0]]))
