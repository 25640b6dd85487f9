r"""Linear forms of the quarter car around its one nonlinearity, from the one right-hand side.

.. math::  x' = A x + B \rho \tanh(\Gamma x) + D_1 \omega, \quad y = C x, \quad F_d = F x

with the duty as rho. No coefficient is written here: every matrix is a difference quotient of
`er_models.rhs.vehicle_rate`, and the result is compared with it at random states before it is
handed out.

Two choices of state. The thesis's (2.11)-(2.14), with absolute velocities and the road's rate as
unknown input, has an invariant zero at s = 0: a car that climbs at constant speed shows no
acceleration. Relative coordinates, with the rate of the tyre deflection as unknown input, do not.

Source: thesis section 2.2; the relative form is ours.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from er_models.errors import ErError, InputError
from er_models.model import Array, Model
from er_models.rhs import vehicle_rate

DIGITS = 12
"""Significant digits kept of every entry: more than any parameter has, the same everywhere."""
TOLERANCE = 1e-8
"""Largest departure from the right-hand side, as a share of each rate's range."""

THESIS_STATES = ("z_def", "v_s", "z_us - z_r", "v_us", "f_y")
RELATIVE_STATES = ("z_def", "z_def'", "z_us - z_r", "f_y")
_RATES = (*(f"d({s})/dt" for s in THESIS_STATES), "sprung acceleration", "unsprung", "F_d")
_USUAL = ("passive", "guo_yield", "response", "quarter_car")
_RELATIVE = np.array([[1, 0, 0, 0, 0], [0, 1, 0, -1, 0], [0, 0, 1, 0, 0], [0, 0, 0, 0, 1]], float)

Rates = Callable[[Array, float, float], Array]
"""Right-hand side and outputs (8,) of state (5,), duty and road rate [m/s]."""


class NotThisForm(ErError):
    """The model has an effect that the linear form with one tanh cannot hold."""


@dataclass(frozen=True, eq=False)
class LinearForm:
    """Matrices of one choice of state: n states, outputs sprung and unsprung acceleration [SI].

    A (n, n), B (n,) at duty 1, D1 (n,) of the unknown input, C (2, n), Gamma (n,), F (n,) row of
    F_d; chart (n, 5) maps the thesis's state to this one.
    """

    states: tuple[str, ...]
    unknown_input: str
    A: Array
    B: Array
    D1: Array
    C: Array
    Gamma: Array
    F: Array
    chart: Array

    @property
    def n(self) -> int:
        """Number of states."""
        return len(self.states)


def thesis_form(model: Model) -> LinearForm:
    """The form (2.11)-(2.14), (2.20) of a vehicle model.

    Raises `InputError` when the quarter car or the response time is missing, `NotThisForm` when
    another effect bends the equations.
    """
    _check_parts(model)
    s = model.scales
    size = np.array([s.deflection, s.velocity, 0.1 * s.deflection, s.velocity, s.force])
    rates = _rates(model)
    jacobian = _jacobian(lambda x: rates(x, 0.0, 0.0), size)
    rest = np.zeros(5)
    b, gamma = _gate(model, rates, size)
    form = LinearForm(
        states=THESIS_STATES,
        unknown_input="d z_r / dt",
        A=_rounded(jacobian[:5]),
        B=_rounded(np.array([0.0, 0.0, 0.0, 0.0, b])),
        D1=_rounded((rates(rest, 0.0, 1.0) - rates(rest, 0.0, -1.0))[:5] / 2.0),
        C=_rounded(jacobian[5:7]),
        Gamma=_rounded(gamma),
        F=_rounded(jacobian[7]),
        chart=np.eye(5),
    )
    _compare(model, form, rates, size)
    return form


def relative_form(model: Model) -> LinearForm:
    """The form in relative coordinates, with d(z_us - z_r)/dt as unknown input.

    Raises as `thesis_form`, and `NotThisForm` when a force depends on an absolute velocity.
    """
    form = thesis_form(model)
    back = np.linalg.pinv(_RELATIVE)
    moved = _RELATIVE @ form.A
    moved[2] = 0.0  # this rate is the unknown input itself
    rows = np.vstack([moved, form.C, form.Gamma, form.F])
    lost = np.abs(rows - rows @ back @ _RELATIVE).max(axis=1)
    if np.any(lost > TOLERANCE * np.abs(rows).max(axis=1)):
        raise NotThisForm(
            f"{model.name}: a force depends on an absolute velocity, which relative coordinates "
            f"do not have; leave out one of {_suspects(model)}"
        )
    return LinearForm(
        states=RELATIVE_STATES,
        unknown_input="d(z_us - z_r) / dt",
        A=_rounded(moved @ back),
        B=_RELATIVE @ form.B,
        D1=np.array([0.0, 0.0, 1.0, 0.0]),
        C=_rounded(form.C @ back),
        Gamma=_rounded(form.Gamma @ back),
        F=_rounded(form.F @ back),
        chart=_RELATIVE,
    )


def fingerprint(model: Model) -> str:
    """Hash of the linear matrices and the gate: what gains depend on, and nothing else."""
    form = thesis_form(model)
    parts = (form.A, form.B, form.D1, form.C, form.Gamma, form.F)
    text = json.dumps([[f"{v:.{DIGITS}g}" for v in np.ravel(part) + 0.0] for part in parts])
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _check_parts(model: Model) -> None:
    """Refuse models without the parts the form is about."""
    for part in ("quarter_car", "response"):
        if part not in model.effects:
            expected = "a vehicle model with a response time"
            raise InputError(model.name, f"effects.{part}", expected, "nothing")
    tau = model.value("response", "tau")
    if not tau > 0.0:
        raise InputError(model.name, "effects.response.tau", "a value above 0 s", tau)


def _rates(model: Model) -> Rates:
    """The model's right-hand side and outputs in the thesis's state."""
    slot = model.catalogue.slots["response"]

    def rates(x: Array, u: float, road_rate: float) -> Array:
        w = np.zeros(max(model.catalogue.n_states, 1))
        w[slot] = x[4]
        dq, dw, outputs = vehicle_rate(model, np.ascontiguousarray(x[:4]), w, u, road_rate)
        return np.concatenate([dq, [dw[slot]], outputs])

    return rates


def _jacobian(function: Callable[[Array], Array], size: Array) -> Array:
    """Central differences at the origin with steps (n,): exact where the function is linear."""
    points = np.diag(size)
    return np.array(
        [(function(x) - function(-x)) / (2.0 * h) for x, h in zip(points, size, strict=True)]
    ).T


def _gate(model: Model, rates: Rates, size: Array) -> tuple[float, Array]:
    """Height of the gate in d(f_y)/dt at duty 1 [N/s] and its Gamma (5,), inverting the tanh."""

    def gate(x: Array) -> float:
        return float(rates(x, 1.0, 0.0)[4] - rates(x, 0.0, 0.0)[4])

    far = 1e4 * size * np.array([0.0, 1.0, 0.0, 0.0, 0.0])
    height = (gate(far) - gate(-far)) / 2.0
    if not height > 0.0:
        raise NotThisForm(
            f"{model.name}: the yield force does not answer the deflection velocity at duty 1; "
            f"leave out one of {_suspects(model)}"
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
    return 0.0  # saturated at any size: `_compare` refuses the form


def _compare(model: Model, form: LinearForm, rates: Rates, size: Array) -> None:
    """Refuse a form that departs from the right-hand side anywhere in the envelope."""
    random = np.random.default_rng(0)
    exact, linear = [], []
    for _ in range(100):
        x, u, w = size * random.uniform(-1, 1, 5), random.uniform(0, 1), random.uniform(-1, 1)
        exact.append(rates(x, u, w))
        value = np.vstack([form.A, form.C, form.F]) @ x
        value[:5] += form.B * u * np.tanh(form.Gamma @ x) + form.D1 * w
        linear.append(value)
    departure = np.abs(np.array(exact) - np.array(linear)).max(axis=0)
    share = departure / np.maximum(np.abs(exact).max(axis=0), 1e-300)
    worst = int(np.argmax(share))
    if not share[worst] <= TOLERANCE:
        raise NotThisForm(
            f"{model.name}: {_RATES[worst]} departs from the linear form with one tanh by "
            f"{100 * share[worst]:.3g} % of its range; leave out one of {_suspects(model)}"
        )


def _suspects(model: Model) -> str:
    """Effects beyond the terms of (2.4) and (2.5)."""
    return ", ".join(name for name in model.effects if name not in _USUAL) or "its core terms"


def _rounded(matrix: Array) -> Array:
    """Entries to `DIGITS` significant digits; what is zero but for rounding becomes zero."""
    small = 1e-12 * np.abs(matrix).max(initial=0.0)
    text = [0.0 if abs(v) <= small else float(f"{v:.{DIGITS}g}") for v in np.ravel(matrix)]
    return np.array(text).reshape(matrix.shape)
