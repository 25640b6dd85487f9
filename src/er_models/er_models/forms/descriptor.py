r"""The Lipschitz descriptor form: the force the damper has lost is a sixth, free state.

.. math::  E x_e' = A_f x_e + B(\rho) \tanh(\Gamma_e x_e) + D_1 \omega_r, \quad y = C x_e

with x_e = [z_def, v_s, z_us - z_r, v_us, F_er, f], five equations for six states, and the force
F_d - f that is left in the damper. Nothing is assumed of f', so f may be any fault: `loss`.

The thesis prints (2.19) with -1/tau in the fourth row, where -1/m_us belongs, and in the column of
the fault in the fifth row, where it belongs to F_er, and B(rho) with four rows; the matrices here
agree with its own (2.18).

Source: thesis (2.15)-(2.19).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from er_models.forms.linearise import check_equal, rounded
from er_models.forms.lipschitz import linearise
from er_models.forms.rates import STATES as HEALTHY
from er_models.forms.rates import rates_of
from er_models.model import Array, Model

STATES = (*HEALTHY, "f")


@dataclass(frozen=True, eq=False)
class DescriptorForm:
    """Matrices of (2.19) [SI]: E, A (5, 6), B (5,) at duty 1, D1 (5,), C (2, 6), Gamma (6,), F (6,) of F_d - f."""

    E: Array
    A: Array
    B: Array
    D1: Array
    C: Array
    Gamma: Array
    F: Array

    def side(self, x: Array, rho: float, road_rate: float) -> Array:
        """E x_e' (5,) of a state (6,), the duty and the rate of the road [m/s]."""
        gate = self.B * (rho * np.tanh(self.Gamma @ x))
        return np.asarray(self.A @ x + gate + self.D1 * road_rate)


def descriptor_form(model: Model) -> DescriptorForm:
    """The form (2.19) of a vehicle model; raises as `linearise`."""
    healthy, rest, lost = linearise(model), np.zeros(5), model.scales.force
    with_loss, with_gain = rates_of(model, lost), rates_of(model, -lost)
    column = (with_loss(rest, 0.0, 0.0) - with_gain(rest, 0.0, 0.0)) / (2.0 * lost)
    form = DescriptorForm(
        E=np.eye(5, 6),
        A=np.column_stack([healthy.A, rounded(column[:5])]),
        B=healthy.B,
        D1=healthy.D1,
        C=np.column_stack([healthy.C, rounded(column[5:7])]),
        Gamma=np.append(healthy.Gamma, 0.0),
        F=np.append(healthy.F, rounded(column[7:])),
    )

    def linear(x: Array, u: float, road_rate: float) -> Array:
        x_e = np.append(x, lost)
        return np.concatenate([form.side(x_e, u, road_rate), form.C @ x_e, [form.F @ x_e]])

    check_equal(model, linear, lost)
    return form
