r"""The force a faulty damper has lost, for the fault column of the descriptor form.

.. math::  f = F_d - f_2 (k_0 x + f_3 (c_0 v + f_1 F_{er}))

f_1: electrical, f_2: oil leakage, f_3: deformation, each 1 when healthy and 0 when all is lost. A
leakage alone is f = alpha F_d with alpha = 1 - f_2.

Source: thesis (2.16), (6.2), (6.4), (6.8), with the dynamic F_er in the place of the static one.
"""

from __future__ import annotations

from er_models.errors import InputError
from er_models.forms.lipschitz import LinearForm
from er_models.model import Array


def lost_force(
    form: LinearForm,
    x: Array,
    electrical: float = 1.0,
    leakage: float = 1.0,
    deformation: float = 1.0,
) -> float:
    """The lost force f [N] in a state (n,) of the thesis's or the relative form.

    Raises `InputError` for a factor outside 0 to 1.
    """
    factors = {"electrical": electrical, "leakage": leakage, "deformation": deformation}
    for name, value in factors.items():
        if not 0.0 <= value <= 1.0:
            raise InputError("fault", name, "a factor from 0 (all lost) to 1 (healthy)", value)
    whole = float(form.F @ x)
    stiff, fluid = float(form.F[0] * x[0]), float(form.F[-1] * x[-1])
    viscous = whole - stiff - fluid
    return whole - leakage * (stiff + deformation * (viscous + electrical * fluid))
