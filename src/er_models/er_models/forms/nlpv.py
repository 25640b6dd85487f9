r"""The nonlinear parameter varying form: the duty schedules the gate.

.. math::  x' = A(x, \rho) + \bar D_1 \omega, \quad A(x, \rho) = A x + B(\rho) \tanh(\Gamma x),
           \quad y = C x + \bar D_2 \omega

with rho = u measured in real time and omega = [omega_r, omega_n]: the unknown input and the noise
of both accelerometers. The thesis writes D2 = beta I and then a column of two numbers; a column
would put the same noise on both sensors, and their difference would be free of it, so D2 is the
diagonal matrix here.

Source: thesis (2.13)-(2.14), (2.21), Table 2.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from er_models.forms.lipschitz import LinearForm, linearise
from er_models.model import Array, Model

DUTY = (0.0, 1.0)
"""Range of the scheduling variable, Table 2.2."""
NOISE = (0.01, 0.01)
"""Weights of the noise of both accelerometers [m/s2], after (2.21)."""


def noise_matrix(noise: Sequence[float]) -> Array:
    """Weighted noise on each of m outputs, of disturbances with an unknown input before it: (m, 1 + m)."""
    return np.column_stack([np.zeros(len(noise)), np.diag(noise)])


@dataclass(frozen=True, eq=False)
class NLPVForm:
    """A form with one gate, scheduled by the duty: n states, 1 + m disturbances, m outputs.

    linear: the matrices; noise (m,): weights of the noise [m/s2]; duty: range of rho.
    """

    linear: LinearForm
    noise: tuple[float, ...] = NOISE
    duty: tuple[float, float] = DUTY

    @property
    def D1_bar(self) -> Array:
        """Input matrix (n, 1 + m) of the disturbances, [D1 0]."""
        quiet = np.zeros((self.linear.n, len(self.noise)))
        return np.column_stack([self.linear.D1, quiet])

    @property
    def D2_bar(self) -> Array:
        """Feedthrough (m, 1 + m) of the disturbances, [0 D2]."""
        return noise_matrix(self.noise)

    def B(self, rho: float) -> Array:
        """The gate's input column (n,) at a duty."""
        return self.linear.B * rho

    def drift(self, x: Array, rho: float) -> Array:
        """A(x, rho) (n,): the part of x' that is known."""
        return np.asarray(
            self.linear.A @ x + self.B(rho) * np.tanh(self.linear.Gamma @ x), np.float64
        )

    def rate(self, x: Array, rho: float, omega: Array) -> Array:
        """Rate x' (n,) of a state (n,), the duty and the disturbances (1 + m,)."""
        return self.drift(x, rho) + self.D1_bar @ omega

    def output(self, x: Array, omega: Array) -> Array:
        """Accelerations (m,) with their noise."""
        return np.asarray(self.linear.C @ x + self.D2_bar @ omega)


def nlpv_form(model: Model) -> NLPVForm:
    """The form (2.13), (2.21) of a vehicle model in the thesis's state; raises as `linearise`."""
    return NLPVForm(linearise(model))
