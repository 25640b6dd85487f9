r"""What a wrong belief leaves of the error of the force when all else is known.

Whoever follows the sprung acceleration finds the force from the body, as the believed mass and spring have it,

.. math::  \hat F = -m_s \ddot z_s - k_s (x + e), \quad
           \overline{m_s \ddot z_s + k_s (x + e) + F_d(x + e, \dot x, u)} = 0

with the true motion, but for its mean: no accelerometer sees that, so it is where the believed damper F_d and the
spring balance. Late sensors make all of it late: where the duty is held nothing tells them from a car that is as late.

It is no bound in the strict sense, an estimate may err the other way and gain a little, but where it is most of the
error nothing but a better belief would help.
"""

from __future__ import annotations

import numpy as np
from er_models.constants import SAMPLE_TIME as DT
from er_models.model import Array, Model
from er_models.prediction import motion, predict
from scipy.optimize import brentq

from er_studies.observers.nrmse import nrmse
from er_studies.observers.scenarios.scenario import Scenario, Window


def floor_of(
    scenario: Scenario, window: Window, record: dict[str, Array], believed: Model
) -> float:
    """NRMSE in a window of a record of `drive` that the believed vehicle leaves."""
    car, t = believed.effects["quarter_car"], record["t"]
    rows = (t >= window.begin - 1e-9) & (t <= window.end + 1e-9)
    x, v, true = (record[n] for n in ("deflection", "deflection_velocity", "damper_force"))
    inertia = car["m_s"] * record["sprung_acceleration"]

    def unbalanced(e: float) -> float:
        force = predict(believed, motion(DT, x + e, v, record["duty"]))
        return float(np.mean((inertia + car["k_s"] * (x + e) + force)[rows]))

    reach = float(np.ptp(true)) / car["k_s"]
    found = -inertia - car["k_s"] * (
        x + float(brentq(unbalanced, -reach, reach, xtol=1e-3 * reach))
    )
    late = round(scenario.sensors.delay / DT)
    told = np.concatenate([np.full(late, found[0]), found[: found.size - late]])
    return nrmse(true[rows], told[rows])
