"""Matrices from a right-hand side that is linear but for one tanh, and the proof that it is."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from er_models.effect import arguments
from er_models.errors import ErError
from er_models.forms.rates import NAMES, Rates, envelope_of, rates_of
from er_models.model import Array, Model

DIGITS = 12
"""Significant digits kept of every entry: more than any parameter has, the same everywhere."""
TOLERANCE = 1e-8
"""Largest departure from the right-hand side, as a share of each rate's range."""
OTHERS, LATER = 1e-3, 1e3
"""A value of any other state [SI] and a time [s] at which the form must still hold."""

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


def check_equal(model: Model, linear: Rates, loss: float = 0.0) -> None:
    """Refuse a form that departs from the right-hand side anywhere in the envelope.

    Nothing but state, duty and road may matter: not the time, no other state, no dead time.
    """
    _check_at_once(model)
    random, size = np.random.default_rng(0), envelope_of(model)
    points = [
        (size * random.uniform(-1, 1, 5), random.uniform(0, 1), random.uniform(-1, 1))
        for _ in range(100)
    ]
    found = np.array([linear(*point) for point in points])
    for others, t, how in (
        (0.0, 0.0, "departs from the linear form with one tanh by {:.3g} % of its range"),
        (OTHERS, 0.0, "follows a state that the form does not have"),
        (0.0, LATER, "changes with time"),
    ):
        exact = rates_of(model, loss, others, t)
        worst, share = _departure(np.array([exact(*point) for point in points]), found)
        if not share <= TOLERANCE:
            text = f"{NAMES[worst]} {how.format(100 * share)}"
            raise NotThisForm(f"{model.name}: {text}; leave out one of {suspects(model)}")


def _departure(wanted: Array, found: Array) -> tuple[int, float]:
    """Which column of (points, 8) is off most, and by which share of its range."""
    share = np.abs(wanted - found).max(axis=0) / np.maximum(np.abs(wanted).max(axis=0), 1e-300)
    return int(np.argmax(share)), float(share.max())


def _check_at_once(model: Model) -> None:
    """Refuse a duty that acts later: no form has a dead time."""
    for name, values in model.effects.items():
        delay = model.catalogue[name].hooks.get("input_delay")
        if delay is not None and delay(**{n: values[n] for n in arguments(delay)}):
            raise NotThisForm(f"{model.name}: the duty acts after a dead time; leave out {name}")


def suspects(model: Model) -> str:
    """Effects beyond the terms of (2.4) and (2.5)."""
    beyond = [*(n for n in model.effects if n not in _USUAL), *(t.name for t in model.terms)]
    return ", ".join(beyond) or "its core terms"


def rounded(matrix: Array) -> Array:
    """Entries to `DIGITS` significant digits; what is zero but for rounding becomes zero."""
    small = 1e-12 * np.abs(matrix).max(initial=0.0)
    text = [0.0 if abs(v) <= small else float(f"{v:.{DIGITS}g}") for v in np.ravel(matrix)]
    return np.array(text).reshape(matrix.shape)
