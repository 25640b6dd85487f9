r"""Gain of the body controller: a linear-quadratic regulator for the whole car.

.. math::  \int \sum_k (\ddot q_k / w_k)^2 + \sum_i (x_i / w_x)^2 + (z_{t,i} / w_t)^2 + (f_i / w_f)^2 \, dt

over heave, roll and pitch accelerations q'', deflections x, tyre deflections z_t and yield forces f. Roads are
forgotten slowly (`FORGET`): a twisted road that stays could be driven out by no force.

Source: Hrovat 1997, Survey of advanced suspension developments, Automatica 33 (10); clipping: Karnopp 1983.
"""

from __future__ import annotations

from dataclasses import astuple

import numpy as np
from er_models.car.body import Car
from er_models.car.linear import linear_car
from er_models.errors import InputError
from er_models.model import Array
from scipy.linalg import LinAlgError, solve_continuous_are

from er_ftc_controller.body_weights import FORGET, BodyWeights


def body_gain(car: Car, weights: BodyWeights) -> Array:
    """Gain K (4, 15) of f = -K s, with the state of `linear_car`.

    Raises:
        InputError: The corners have no linear form, or no gain solves the problem.
    """
    form = linear_car(car)
    a, b = form.A.copy(), form.B
    a[7:11, 7:11] -= FORGET * np.eye(4)
    of_state, of_force = form.acceleration
    motions, x, tyre, force = np.split(np.array(astuple(weights)), [3, 4, 5])
    c = np.vstack([of_state / motions[:, None], np.eye(15)[:4] / x, np.eye(15)[7:11] / tyre])
    d = np.vstack([of_force / motions[:, None], np.zeros((8, 4))])
    r = d.T @ d + np.eye(4) / force**2
    try:
        p = solve_continuous_are(a, b, c.T @ c, r, s=c.T @ d)
    except (LinAlgError, ValueError) as error:
        raise InputError(car.name, "weights", "weights that a gain solves", str(error)) from error
    return np.asarray(np.linalg.solve(r, b.T @ p + d.T @ c))
