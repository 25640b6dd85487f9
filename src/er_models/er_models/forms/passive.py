"""The passive car: what the road does to body, wheel and deflection without field.

Source: thesis figures 6.13 to 6.15, from (2.8) with u_er = 0.
"""

from __future__ import annotations

import numpy as np

from er_models.forms.lti import lti_form
from er_models.forms.response import Complex, Peak, frequency_response, peaks
from er_models.model import Array, Model

OUTPUTS = ("z_s", "z_us", "z_def")
_ROWS = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [1, 0, -1, 0]], float)


def passive_response(model: Model, hertz: Array) -> Complex:
    """z_s, z_us and z_def over z_r at frequencies (k,) [Hz], shape (k, 3); raises as `lti_form`."""
    form = lti_form(model)
    response = frequency_response(form.A, form.D[:, None], _ROWS, hertz)
    return np.asarray(response[:, :, 0])


def passive_peaks(model: Model, hertz: Array) -> dict[str, list[Peak]]:
    """Peaks of each of `OUTPUTS` over z_r within rising frequencies (k,) [Hz]; a peak lies between points."""
    gains = np.abs(passive_response(model, hertz))
    return {name: peaks(hertz, gains[:, i]) for i, name in enumerate(OUTPUTS)}
