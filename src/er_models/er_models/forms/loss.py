r"""The force a faulty damper has lost, for the fault column of the descriptor form.

.. math::  f = F_d - f_2 (k_0 x + f_3 (c_0 v + f_1 F_{er}))

A leakage alone is f = alpha F_d with alpha = 1 - f_2.

Source: thesis (2.16), (6.2), (6.4), (6.8), with the dynamic F_er in the place of the static one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from er_models.errors import InputError
from er_models.forms.linearise import TOLERANCE, NotThisForm
from er_models.forms.lipschitz import LinearForm, linearise
from er_models.model import Array, Model


@dataclass(frozen=True)
class Factors:
    """What faults leave of the damper: electrical f_1, leakage f_2, deformation f_3, each 1 when healthy, 0 when lost.

    Raises `InputError` for a factor outside 0 to 1.
    """

    electrical: float = 1.0
    leakage: float = 1.0
    deformation: float = 1.0

    def __post_init__(self) -> None:
        for name in ("electrical", "leakage", "deformation"):
            value = getattr(self, name)
            if not 0.0 <= value <= 1.0:
                expected = "a factor from 0 (all lost) to 1 (healthy)"
                raise InputError("fault", name, expected, value)


def lost_force(form: LinearForm, x: Array, left: Factors) -> float:
    """The lost force f [N] in a state (n,) of the thesis's or the relative form.

    Raises `NotThisForm` where the force is not the sum of stiffness, viscosity and F_er.
    """
    check_sum(form)
    whole = float(form.F @ x)
    stiff, fluid = float(form.F[0] * x[0]), float(form.F[-1] * x[-1])
    viscous = whole - stiff - fluid
    return whole - left.leakage * (stiff + left.deformation * (viscous + left.electrical * fluid))


def damaged(model: Model, left: Factors) -> Model:
    """The same car with the faults in its parameters: f_2 k0, f_2 f_3 c0 and f_1 f_2 f_3 f_c.

    Raises as `linearise` and `lost_force`.
    """
    check_sum(linearise(model))
    viscous = left.leakage * left.deformation
    scales = {
        ("passive", "k0"): left.leakage,
        ("passive", "c0"): viscous,
        ("guo_yield", "f_c"): viscous * left.electrical,
    }
    effects = {name: dict(values) for name, values in model.effects.items()}
    for (effect, parameter), scale in scales.items():
        effects[effect][parameter] *= scale
    return replace(model, effects=effects)


def check_sum(form: LinearForm) -> None:
    """Raise `NotThisForm` where the inertia of the fluid takes part of F_er, so that (6.8) does not hold."""
    if abs(form.F[-1] - 1.0) > TOLERANCE:
        raise NotThisForm("(6.8) knows no inertia of the fluid; leave out fluid_inertia")
