r"""The Lipschitz form without absolute velocities: the one the gains are computed for.

.. math::  x_r = [z_{def}, z_{def}', z_{us} - z_r, F_{er}]

with the rate of the tyre deflection as unknown input. A climb at constant speed is rest here, so
(A, D1, C) has no invariant zero, while rank(C D1) = rank(D1) = 1 still holds and the damper force
loses nothing.

Source: ours; the thesis's wish for an observer of reduced order (its perspectives).
"""

from __future__ import annotations

import numpy as np

from er_models.forms.linearise import TOLERANCE, NotThisForm, rounded, suspects
from er_models.forms.lipschitz import LinearForm, linearise
from er_models.model import Model

STATES = ("z_def", "z_def'", "z_us - z_r", "f_y")
_CHART = np.array([[1, 0, 0, 0, 0], [0, 1, 0, -1, 0], [0, 0, 1, 0, 0], [0, 0, 0, 0, 1]], float)


def relative_form(model: Model) -> LinearForm:
    """The form in relative coordinates, with d(z_us - z_r)/dt as unknown input.

    Raises as `linearise`, and `NotThisForm` when a force depends on an absolute velocity.
    """
    form = linearise(model)
    back = np.linalg.pinv(_CHART)
    moved = _CHART @ form.A
    moved[2] = 0.0  # this rate is the unknown input itself
    rows = np.vstack([moved, form.C, form.Gamma, form.F])
    lost = np.abs(rows - rows @ back @ _CHART).max(axis=1)
    if np.any(lost > TOLERANCE * np.abs(rows).max(axis=1)):
        raise NotThisForm(
            f"{model.name}: a force depends on an absolute velocity, which relative coordinates "
            f"do not have; leave out one of {suspects(model)}"
        )
    return LinearForm(
        states=STATES,
        unknown_input="d(z_us - z_r) / dt",
        A=rounded(moved @ back),
        B=_CHART @ form.B,
        D1=np.array([0.0, 0.0, 1.0, 0.0]),
        C=rounded(form.C @ back),
        Gamma=rounded(form.Gamma @ back),
        F=rounded(form.F @ back),
        chart=_CHART,
    )
