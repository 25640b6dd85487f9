"""How wrong an observer starts, in the thesis's state [z_def, v_s, z_us - z_r, v_us, F_er] from rest.

The thesis starts its observers differently: the NLPV ones 10 mm wrong in deflection (4.5), the
unified one from z_0 of (3.5), which its printed R turns into 1.05 mm. One start says little of an
estimator that is told how wrong its start may be: drawn starts are all that this covariance allows.
"""

from __future__ import annotations

import numpy as np
from er_models.linear import LinearForm
from er_models.model import Array
from er_observers.opening.phase import FARTHEST

from er_studies.observers.scenarios.scenario import Scenario

NLPV = np.array([0.01, -0.1, 0.001, -0.1, 5.0])
_Z_0 = np.array([0.01, -0.4, 0.001, -0.15, 2.0])
R = np.array([
    [0.0017, 0.0017, -7.4710e-05, 1.8433e-05, -1.9070e-04],
    [-0.0906, 1.6206e-05, -7.1142e-07, 3.4945e-07, 8.9622e-06],
    [-3.2373e-07, -3.2373e-07, -3.2373e-07, -3.5062e-09, -1.8944e-05],
    [-1.6206e-05, 0.0906, 7.1142e-07, -3.4945e-07, -8.9622e-06],
    [7.1142e-07, 7.1142e-07, 0.0906, 1.5340e-08, 3.9342e-07],
])  # fmt: skip
SPREAD = (0.01, 0.1, 0.001, 5.0)
"""Standard deviations of drawn starts in relative coordinates [SI]; what the Kalman filters are told of any start."""
_START = 5
"""Stream of random numbers, beside those of plant and noise (`drive`)."""
UNIFIED = R @ _Z_0
"""R z_0, R as printed in 3.4.1; at rest the accelerations add nothing."""


def first_state(
    scenario: Scenario, form: LinearForm, observer: str, record: dict[str, Array], number: int = 0
) -> Array | None:
    """The wrong first state (n,) in the coordinates of `form`; None where the observer finds its own.

    number: of the road; drawn starts are another one for each, the same for every observer. Errors
    are added to the true first state, which is rest for every scenario of the thesis.
    """
    if scenario.start == "own":
        return None
    if scenario.start == "drawn":
        random = np.random.default_rng([scenario.program.seed + number, _START])
        x: Array = np.array(SPREAD) * random.normal(size=len(SPREAD)).clip(-FARTHEST, FARTHEST)
    else:
        unified = scenario.start == "thesis" and observer == "unified"
        x = np.asarray(form.chart @ (UNIFIED if unified else NLPV), float)
    true = ("deflection", "deflection_velocity", "tyre_deflection")
    x[:3] += [record[name][0] for name in true]
    return x
