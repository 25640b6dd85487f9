"""What two accelerometers can tell of the car, with a known or an unknown fault, with or without a deflection sensor.

A motion that makes no sensor move cannot be told from rest. `Sensing.zeros` lists the rates of such
motions; one that does not decay (real part not below 0) leaves an error that no observer removes
while it knows nothing of the unknown inputs.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from er_models.forms.descriptor import descriptor_form
from er_models.forms.lipschitz import LinearForm, linearise
from er_models.forms.relative import relative_form
from er_models.forms.zeros import invariant_zeros
from er_models.model import Array, Model

STATES = ("absolute", "relative")
UNKNOWNS = (("road",), ("road", "lost force"))
SENSORS = (("accelerations",), ("accelerations", "deflection"))


@dataclass(frozen=True, eq=False)
class Sensing:
    """x' = A x + D w, y = C x + H w, for a choice of velocities, of unknown inputs w and of sensors y."""

    velocities: str
    unknowns: tuple[str, ...]
    sensors: tuple[str, ...]
    A: Array
    D: Array
    C: Array
    H: Array

    @property
    def zeros(self) -> Array:
        """Invariant zeros [1/s]."""
        return invariant_zeros(self.A, self.D, self.C, self.H)


def sensings(model: Model) -> tuple[Sensing, ...]:
    """All eight choices for a vehicle model with its gate beyond yield; raises as `relative_form`."""
    forms = {"absolute": linearise(model), "relative": relative_form(model)}
    lost = descriptor_form(model)
    return tuple(
        _sensing(velocities, forms[velocities], unknowns, sensors, lost.A[:, 5], lost.C[:, 5])
        for velocities, unknowns, sensors in product(STATES, UNKNOWNS, SENSORS)
    )


def _sensing(
    velocities: str,
    form: LinearForm,
    unknowns: tuple[str, ...],
    sensors: tuple[str, ...],
    lost_rate: Array,
    lost_output: Array,
) -> Sensing:
    """One choice: columns for the unknown inputs, rows for the sensors."""
    D = np.column_stack([form.D1, form.chart @ lost_rate])[:, : len(unknowns)]
    C = np.vstack([form.C, np.eye(form.n)[0]])[: 1 + len(sensors)]
    H = np.column_stack([np.zeros(3), np.append(lost_output, 0.0)])[: len(C), : len(unknowns)]
    return Sensing(velocities, unknowns, sensors, form.A, D, C, H)
