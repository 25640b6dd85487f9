"""Matrices from a right-hand side that is linear but for one tanh, and the proof that it is."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from er_models.errors import ErError
from er_models.forms.rates import NAMES, Rates
from er_models.model import Array, Model

DIGITS = 12
"""Significant digits kept of every entry: more than any parameter has, the same everywhere."""
TOLERANCE = 1e-8
"""Largest departure from the right-hand side, as a share of each rate's range."""

_USUAL = ("passive", "guo_yield", "response", "quarter_car")


class NotThisForm(ErError):
    """The model has an effect that the form cannot hold."""


def jacobian(function: Callable[[Array], Array], size: Array) -> Array:
    """Central differences at the origin with steps (n,): exact where the function is linear."""
    points = np.diag(size)
    return np.array(
        [(function(x) - function(-x)) / (2.0 * h) for x, h in zip(points, size, strict=True)]
    ).T


def gate_of(model: Model, rates: Rates, size: Array) -> tuple[float, Array]:
    """Height of the gate in d(f_y)/dt at duty 1 [N/s] and its Gamma (5,), inverting the tanh."""

    def gate(x: Array) -> float:
        return float(rates(x, 1.0, 0.0)[4] - rates(x, 0.0, 0.0)[4])

    far = 1e4 * size * np.array([0.0, 1.0, 0.0, 0.0, 0.0])
    height = (gate(far) - gate(-far)) / 2.0
    if not height > 0.0:
        raise NotThisForm(
            f"{model.name}: the yield force does not answer the deflection velocity at duty 1; "
            f"leave out one of {suspects(model)}"
        )
    return height, np.array([_slope(gate, height, i, step) for i, step in enumerate(size)])


def _slope(gate: Callable[[Array], float], height: float, i: int, step: float) -> float:
    """Entry i of Gamma, from a point where the tanh is neither small nor saturated."""
    x = np.zeros(5)
    for _ in range(60):
        x[i] = step
        share = gate(x) / height
        if share == 0.0:
            return 0.0
        if abs(share) < 0.8:
            x[i] = step = 0.5 * step / abs(np.arctanh(share))
            return float(np.arctanh(gate(x) / height) / step)
        step /= 4.0
    return 0.0  # saturated at any size: `check_equal` refuses the form


def check_equal(model: Model, exact: Rates, linear: Rates, size: Array) -> None:
    """Refuse a form that departs from the right-hand side anywhere in the envelope."""
    random = np.random.default_rng(0)
    points = [
        (size * random.uniform(-1, 1, 5), random.uniform(0, 1), random.uniform(-1, 1))
        for _ in range(100)
    ]
    wanted = np.array([exact(*point) for point in points])
    departure = np.abs(wanted - np.array([linear(*point) for point in points])).max(axis=0)
    share = departure / np.maximum(np.abs(wanted).max(axis=0), 1e-300)
    worst = int(np.argmax(share))
    if not share[worst] <= TOLERANCE:
        raise NotThisForm(
            f"{model.name}: {NAMES[worst]} departs from the linear form with one tanh by "
            f"{100 * share[worst]:.3g} % of its range; leave out one of {suspects(model)}"
        )


def suspects(model: Model) -> str:
    """Effects beyond the terms of (2.4) and (2.5)."""
    return ", ".join(name for name in model.effects if name not in _USUAL) or "its core terms"


def rounded(matrix: Array) -> Array:
    """Entries to `DIGITS` significant digits; what is zero but for rounding becomes zero."""
    small = 1e-12 * np.abs(matrix).max(initial=0.0)
    text = [0.0 if abs(v) <= small else float(f"{v:.{DIGITS}g}") for v in np.ravel(matrix)]
    return np.array(text).reshape(matrix.shape)
