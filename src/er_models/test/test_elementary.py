"""The kernel's own elementary functions against the C library's, over all a double can hold."""

from __future__ import annotations

import math

import numpy as np
from er_models.kernel.elementary import LARGEST, PIECES, exp, tanh
from er_models.kernel.fast import njit


@njit
def exponentials(x, out):
    for i in range(x.size):
        out[i] = exp(x[i])


@njit
def tangents(x, out):
    for i in range(x.size):
        out[i] = tanh(x[i])


def points():
    """Random ones, the edges between pieces, and the smallest."""
    random = np.random.default_rng(0)
    edges = np.arange(-40 * PIECES, 40 * PIECES) * math.log(2.0) / PIECES / 2.0
    small = 10.0 ** -np.arange(1.0, 320.0, 7.0)
    return np.concatenate(
        [random.uniform(-LARGEST, LARGEST, 20_000), random.uniform(-1, 1, 20_000), edges, small, -small, [0.0]]
    )  # fmt: skip


def test_exponential_errs_by_one_unit_of_the_last_place_at_most():
    x = points()
    found = np.empty_like(x)
    exponentials(x, found)
    assert (np.abs(found - np.exp(x)) <= 1.001 * np.spacing(np.exp(x))).all()


def test_hyperbolic_tangent_errs_by_rounding_only():
    x = points()
    found = np.empty_like(x)
    tangents(x, found)
    assert np.abs(found - np.tanh(x)).max() < 3e-16


def test_what_is_too_large_is_cut_and_what_is_no_number_stays_none():
    x = np.array([math.inf, 1e4, -1e4, -math.inf, math.nan])
    found = np.empty_like(x)
    exponentials(x, found)
    assert np.allclose(found[:2], math.exp(LARGEST), rtol=1e-12)
    assert (found[2:4] > 0.0).all()
    assert (found[2:4] < 1e-300).all()
    assert math.isnan(found[4])
    tangents(x, found)
    assert found[:4].tolist() == [1.0, 1.0, -1.0, -1.0]
    assert math.isnan(found[4])
