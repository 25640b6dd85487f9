"""Derivatives of what a model computes by its parameters: difference quotients, all columns in one batch.

Each parameter declares its step (`Param.step`). Where the equations are smooth, a few millionths of the value err
as little as exact derivatives would for any fit. Where a jump moves with the parameter, so small a step sees it in one
sample or in none, and a longer secant sees what many of them do together. The steps were measured:
docs/decisions/0004-sensitivities.md.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from er_models.effect import Param
from er_models.model import Array

Rows = Callable[[Array], Array]
"""Outputs (m, n) at points (m, p), for instance `predict_many`."""
LEAST = 0.1
"""A step is a share of the value, or of this much of the parameter's size where the value is smaller."""
BEYOND_MEASURE = 1e100
"""A derivative as large is none: sums of the squares of larger ones are no numbers."""


def steps(parameters: Sequence[Param], values: Array, share: float | None = None) -> Array:
    """Steps (p,) of a difference quotient at values (p,), both in multiples of the natural scales.

    They point into the box. share: of the values, in place of what the parameters declare.
    """
    shares = np.array([q.step if share is None else share for q in parameters])
    size, high = (np.array([getattr(q, n) for q in parameters]) for n in ("size", "high"))
    step = shares * np.maximum(np.abs(values), LEAST * size)
    return np.asarray(np.where(values + step > high, -step, step))


def quotients(
    rows: Rows, at: Array, step: Array, here: Array, columns: NDArray[np.intp] | None = None
) -> Array:
    """Derivatives (n, columns) of rows by coordinates of a point at (p,): those of some columns, or all.

    here (n,): outputs at the point; zero where the model gives no number, or one beyond measure.
    """
    along = np.arange(at.size) if columns is None else columns
    points = (at + np.diag(step))[along]
    exact = (points - at)[:, along].diagonal()
    with np.errstate(invalid="ignore", over="ignore"):
        change = (rows(points) - here).T / exact
    return np.where(np.abs(change) < BEYOND_MEASURE, change, 0.0)
