"""Linear forms that gains are made for: which velocities are states, which sensors are outputs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from er_models.linear import LinearForm, linearise, relative_form
from er_models.model import Model

COORDINATES = {"relative": relative_form, "absolute": linearise}
SENSORS = ("sprung acceleration", "unsprung acceleration", "deflection")


def form_of(
    model: Model, coordinates: str = "relative", *, deflection: bool = False
) -> LinearForm:
    """A form of `COORDINATES`; deflection: its sensor is an output as well, the last.

    Raises as `relative_form` and `linearise`.
    """
    form = COORDINATES[coordinates](model)
    return with_deflection(form) if deflection else form


def with_deflection(form: LinearForm) -> LinearForm:
    """The form with the deflection as third output."""
    return replace(form, C=np.vstack([form.C, np.eye(form.n)[0]]))
