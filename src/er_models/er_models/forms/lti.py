r"""Subsystem 1: the suspension alone, linear, with the fluid's force and the road as inputs.

.. math::  x_s' = A_s x_s + B_s u_{er} + D_{s\omega} z_r, \quad
           y = C x_s + D_u u_{er} + D_r z_r, \quad F_d = F x_s + u_{er}

with x_s = [z_s, z_s', z_us, z_us'] and y = [z_s'', z_us'', z_def]. It follows from the Lipschitz
form by q = T x_s + t z_r: the road's rate drops out where it enters by the tyre's deflection only.

Source: thesis (2.7)-(2.8), outputs (2.20) and 6.3.1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from er_models.forms.linearise import TOLERANCE, NotThisForm, rounded, suspects
from er_models.forms.lipschitz import linearise
from er_models.model import Array, Model

STATES = ("z_s", "v_s", "z_us", "v_us")
OUTPUTS = ("sprung acceleration", "unsprung acceleration", "z_def")
_T = np.array([[1, 0, -1, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], float)
_t = np.array([0.0, 0.0, -1.0, 0.0])


@dataclass(frozen=True, eq=False)
class LTIForm:
    """Matrices of (2.8) [SI]: A (4, 4), B (4,) of u_er, D (4,) of z_r, outputs C (3, 4), C_u, C_r (3,), F (4,)."""

    A: Array
    B: Array
    D: Array
    C: Array
    C_u: Array
    C_r: Array
    F: Array

    def rate(self, x: Array, force: float, road: float) -> Array:
        """Rate x_s' (4,) of a state (4,), the fluid's force u_er [N] and the road's height [m]."""
        return np.asarray(self.A @ x + self.B * force + self.D * road)

    def output(self, x: Array, force: float, road: float) -> Array:
        """Both accelerations [m/s2] and the deflection [m], (3,)."""
        return np.asarray(self.C @ x + self.C_u * force + self.C_r * road)


def lti_form(model: Model) -> LTIForm:
    """The form (2.8) of a vehicle model.

    Raises as `linearise`, and `NotThisForm` when the rate of the road acts by itself.
    """
    form = linearise(model)
    if np.abs(form.D1[:4] - _t).max() > TOLERANCE:
        raise NotThisForm(
            f"{model.name}: the rate of the road acts beside the tyre's deflection, and (2.8) knows "
            f"only the road's height; leave out one of {suspects(model)}"
        )
    back, motion, force = np.linalg.inv(_T), form.A[:4, :4], form.A[:4, 4]
    outputs = np.vstack([form.C[:, :4], [1.0, 0.0, 0.0, 0.0]])
    return LTIForm(
        A=rounded(back @ motion @ _T),
        B=rounded(back @ force),
        D=rounded(back @ motion @ _t),
        C=rounded(outputs @ _T),
        C_u=np.append(form.C[:, 4], 0.0),
        C_r=rounded(outputs @ _t),
        F=rounded(form.F[:4] @ _T),
    )
