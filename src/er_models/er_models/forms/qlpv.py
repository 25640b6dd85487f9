r"""Subsystem 2: the fluid's force, with its gate as scheduling variable.

.. math::  F_{er}' = A_{lc} F_{er} + B_{lc}(\rho_{lc}) u, \quad
           \rho_{lc} = \tanh(k_1 z_{def} + c_1 z_{def}') \in (-1, 1)

Source: thesis (2.9)-(2.10).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from er_models.forms.linearise import NotThisForm, suspects
from er_models.forms.relative import relative_form
from er_models.model import Array, Model


@dataclass(frozen=True, eq=False)
class QLPVForm:
    """A_lc [1/s], B_lc at an open gate [N/s], Gamma (2,) of the motion [z_def, z_def']."""

    A: float
    B: float
    Gamma: Array

    def gate(self, motion: Array) -> float:
        """rho_lc [1] of the deflection and its velocity (2,)."""
        return float(np.tanh(self.Gamma @ motion))

    def rate(self, force: float, duty: float, gate: float) -> float:
        """Rate of the fluid's force [N/s]."""
        return self.A * force + self.B * gate * duty


def qlpv_form(model: Model) -> QLPVForm:
    """The form (2.10) of a vehicle model.

    Raises as `relative_form`, and `NotThisForm` when the fluid's force follows the motion by
    another way than its gate.
    """
    form = relative_form(model)
    if np.any(form.A[3, :3]) or np.any(form.B[:3]) or np.any(form.Gamma[2:]):
        raise NotThisForm(
            f"{model.name}: the yield force follows the motion beside its gate; "
            f"leave out one of {suspects(model)}"
        )
    return QLPVForm(float(form.A[3, 3]), float(form.B[3]), form.Gamma[:2])
