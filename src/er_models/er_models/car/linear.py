"""The whole car as matrices: corners from the quarter car's own linear form, coupled by body and bars."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from er_models.car.body import Car
from er_models.forms.lipschitz import linearise
from er_models.model import Array


@dataclass(frozen=True, eq=False)
class LinearCar:
    """s' = A s + B f + D r', s = [deflections (4), rates of heave, roll, pitch, tyre deflections (4), v_us (4)].

    f (4,): yield forces of the dampers [N], r' (4,): rates of the roads [m/s]. acceleration: of heave, roll, pitch from
    s, (3, 15), and from f, (3, 4).
    """

    A: Array
    B: Array
    D: Array
    acceleration: tuple[Array, Array]


def linear_car(car: Car) -> LinearCar:
    """The car around rest, without field.

    Raises `InputError` and `NotThisForm` as `linearise` does for a corner.
    """
    forms = [linearise(model).A for model in car.corners]
    masses = [model.value("quarter_car", "m_s") for model in car.corners]
    wheels = np.array([model.value("quarter_car", "m_us") for model in car.corners])
    bars = car.bars
    eye, zero, body = np.eye(4), np.zeros((4, 4)), car.shape
    # rows of a corner's form: what presses on its body, -m_s v_s', and v_us'
    press, wheel = (
        np.array([scale * form[row] for form, scale in zip(forms, scales)])
        for row, scales in ((1, [-m for m in masses]), (3, [1.0] * 4))
    )
    twist = np.diag(bars) @ (eye - np.roll(eye.reshape(2, 2, 4), 1, axis=1).reshape(4, 4))
    p = np.hstack(
        [
            np.diag(press[:, 0]) + twist,
            press[:, 1:2] * body,
            np.diag(press[:, 2]),
            np.diag(press[:, 3]),
        ]
    )
    w = np.hstack([
        np.diag(wheel[:, 0]) + twist / wheels[:, None], wheel[:, 1:2] * body, np.diag(wheel[:, 2]), np.diag(wheel[:, 3])
    ])  # fmt: skip
    to_body = -car.inverse_mass @ body.T
    a = np.vstack([
        np.hstack([zero, body, zero, -eye]),
        to_body @ p,
        np.hstack([zero, np.zeros((4, 3)), zero, eye]),
        w,
    ])  # fmt: skip
    pushed = to_body @ np.diag(press[:, 4])
    b = np.vstack([zero, pushed, zero, np.diag(wheel[:, 4])])
    d = np.vstack([zero, np.zeros((3, 4)), -eye, zero])
    return LinearCar(a, b, d, (to_body @ p, pushed))
