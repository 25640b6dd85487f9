"""Derivatives by difference quotients."""

from __future__ import annotations

import numpy as np
import pytest
from er_models.model import Array
from er_models.sensitivity import quotients


@pytest.mark.parametrize("output", [np.nan, np.inf, -np.inf, 1e200])
def test_where_a_point_gives_no_number_the_derivative_is_zero_and_its_square_is_one(
    output: float,
) -> None:
    """An exponent a step higher may overflow: what follows sums squares, and a decomposition of infinities raises."""

    def rows(points: Array) -> Array:
        found = points @ np.array([[3.0, 1.0, 0.0], [0.0, 2.0, 5.0]])
        found[0, 1] = output
        return found

    at = np.array([1.0, 2.0])
    here = at @ np.array([[3.0, 1.0, 0.0], [0.0, 2.0, 5.0]])
    found = quotients(rows, at, np.array([1e-3, 1e-3]), here)
    assert found == pytest.approx(np.array([[3.0, 0.0], [0.0, 2.0], [0.0, 5.0]]), rel=1e-9)
    assert np.isfinite(np.linalg.pinv(found.T @ found)).all()
