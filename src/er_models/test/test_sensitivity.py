"""Derivatives by difference quotients."""

from __future__ import annotations

import numpy as np
import pytest
from er_models.model import Array
from er_models.prediction import motion, predict
from er_models.sensitivity import quotients
from models_help import bingham


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


@pytest.mark.parametrize("name", ["rise_fall_asymmetry.r", "response.tau"])
def test_a_response_that_rises_and_falls_unlike_is_smooth_in_its_values(name: str) -> None:
    """At rest on a plateau nothing but rounding says whether the force rises or falls."""
    dt, effect, parameter = 0.01, *name.split(".")
    t = np.arange(1200) * dt
    x = 0.008 * np.sin(9.0 * t) + 0.003 * np.sin(31.0 * t)
    inputs = motion(dt, x, np.gradient(x, dt), np.repeat([0.05, 0.25, 0.1, 0.3], 300))
    model = bingham().with_effect("response", {"tau": 0.009})
    model = model.with_effect("rise_fall_asymmetry", {"r": 1.5})
    value, here = model.value(effect, parameter), predict(model, inputs)

    def slope(share: float) -> Array:
        values = model.effects[effect] | {parameter: value * (1.0 + share)}
        return (predict(model.with_effect(effect, values), inputs) - here) / (share * value)

    short, long = slope(1e-6), slope(1e-3)
    assert np.linalg.norm(short - long) < 0.05 * np.linalg.norm(long)
