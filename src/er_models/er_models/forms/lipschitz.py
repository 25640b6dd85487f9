r"""The nonlinear Lipschitz form: the whole car around its one nonlinearity.

.. math::  x' = A x + B \tanh(\Gamma x) u + D_1 \omega_r, \quad y = C x, \quad F_d = F x

with x = [z_def, v_s, z_us - z_r, v_us, F_er] and the road's rate as unknown input. A constant
climb shows in no acceleration, so (A, D1, C) has an invariant zero at s = 0; the form in
`relative` coordinates has none.

Source: thesis (2.11)-(2.12), outputs (2.20), force (2.22).
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass

import numpy as np

from er_models.forms.linearise import DIGITS, check_equal, gate_of, jacobian, rounded
from er_models.forms.rates import STATES, rates_of, sizes_of
from er_models.model import Array, Model


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

    def rate(self, x: Array, u: float, unknown: float) -> Array:
        """Rate x' (n,) of a state (n,), the duty and the unknown input [m/s]."""
        return np.asarray(self.A @ x + self.B * (u * np.tanh(self.Gamma @ x)) + self.D1 * unknown)

    def frozen(self, u: float, slope: float) -> Array:
        """State matrix (n, n) at a held duty, the gate on a line through zero; slope 1 before yield, 0 far beyond."""
        return np.asarray(self.A + u * slope * np.outer(self.B, self.Gamma))


def linearise(model: Model) -> LinearForm:
    """A car as matrices around its one nonlinearity, exact over the whole envelope and at every duty.

    `form.frozen(duty, slope)` is the state matrix (5, 5) where the gate is a line too: linear altogether.

    Source: thesis (2.11)-(2.12), (2.20).

    Raises:
        InputError: No quarter car in the model, or no constant response time.
        NotThisForm: Another effect bends the equations; the message says which to leave out.
    """
    rates, size, rest = rates_of(model), sizes_of(model), np.zeros(5)
    slopes = jacobian(lambda x: rates(x, 0.0, 0.0), size)
    b, gamma = gate_of(model, rates, size)
    form = LinearForm(
        states=STATES,
        unknown_input="d z_r / dt",
        A=rounded(slopes[:5]),
        B=rounded(np.array([0.0, 0.0, 0.0, 0.0, b])),
        D1=rounded((rates(rest, 0.0, 1.0) - rates(rest, 0.0, -1.0))[:5] / 2.0),
        C=rounded(slopes[5:7]),
        Gamma=rounded(gamma),
        F=rounded(slopes[7]),
        chart=np.eye(5),
    )

    def linear(x: Array, u: float, road_rate: float) -> Array:
        return np.concatenate([form.rate(x, u, road_rate), form.C @ x, [form.F @ x]])

    check_equal(model, linear)
    return form


def fingerprint(model: Model) -> str:
    """Hash of the linear matrices and the gate: what gains depend on, and nothing else."""
    form = linearise(model)
    parts = (form.A, form.B, form.D1, form.C, form.Gamma, form.F)
    text = json.dumps([[f"{v:.{DIGITS}g}" for v in np.ravel(part) + 0.0] for part in parts])
    return hashlib.sha256(text.encode()).hexdigest()[:16]
